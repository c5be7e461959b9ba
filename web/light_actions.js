// What is done with a light as a whole: another one like it, all others off, a warmer or cooler one.

import { KELVIN, ofTemperature, strength, temperatureOf } from "./colour.js";
import { element, slider } from "./fields.js";
import { add, scale } from "./vector.js";

const BESIDE = 0.06; // of the scene's size: where a copy stands

// Buttons for a light; show() brings them up to date.
export function actions(state, id) {
  const button = (text, title, act) => {
    const made = element("button", { type: "button", textContent: text, title });
    made.addEventListener("click", act);
    return made;
  };
  const alone = button("Solo", "All other lights off, and on again", () => solo(state, id));
  const box = element("div", { className: "buttons" });
  box.append(button("Duplicate", "Another one like it, beside it", () => duplicate(state, id)), alone);
  const show = () => alone.setAttribute("aria-pressed", String(isAlone(state, id)));
  return { row: box, show };
}

function duplicate(state, id) {
  const light = structuredClone(state.light(id));
  const stem = id.replace(/-\d+$/, "");
  let number = 2;
  while (state.light(`${stem}-${number}`)) number += 1;
  const aside = scale([1, 0, 0], BESIDE * state.scene.diagonal);
  const moved = light.position ? { position: add(light.position, aside) } : {};
  const copy = { ...light, ...moved, id: `${stem}-${number}` };
  state.setLights([...state.lights, copy], copy.id);
}

const remembered = new WeakMap(); // by state: {id, on}: which lights were on before one was alone

function isAlone(state, id) {
  const before = remembered.get(state);
  const only = state.lights.every((light) => light.enabled === (light.id === id));
  return before?.id === id && only;
}

function solo(state, id) {
  if (isAlone(state, id)) {
    const { on } = remembered.get(state);
    remembered.delete(state);
    state.setLights(state.lights.map((light) => ({ ...light, enabled: on.has(light.id) })));
    return;
  }
  // From one that is alone to another: those that were on before the first.
  const before = remembered.get(state);
  const on = before && isAlone(state, before.id)
    ? before.on
    : new Set(state.lights.filter(({ enabled }) => enabled).map((light) => light.id));
  remembered.set(state, { id, on });
  state.setLights(state.lights.map((light) => ({ ...light, enabled: light.id === id })), id);
}

// A slider of black bodies' colours, in steps that look alike; the strength stays.
export function temperature(change) {
  let light = null;
  return slider(
    "Temperature",
    { min: -1e6 / KELVIN.min, max: -1e6 / KELVIN.max, step: 1 },
    "K",
    {
      title: "Colour of a black body: candles 1,900, lamps 2,700 to 4,000, daylight 6,500",
      least: KELVIN.min,
      most: KELVIN.max,
      toSlider: (kelvin) => -1e6 / kelvin,
      fromSlider: (mired) => -1e6 / mired,
      get: (now) => {
        light = now;
        return Math.round(temperatureOf(now.intensity) ?? 6500);
      },
      change: (kelvin, moving) => {
        const s = strength(light.intensity);
        change({ intensity: ofTemperature(kelvin).map((c) => c * s) }, moving);
      },
    },
  );
}
