// What is done with the lights that are selected, as a whole: others like them, all others off, locked,
// moved or scaled together, a warmer or cooler one, a stronger one.

import { KELVIN, ofTemperature, strength, temperatureOf } from "./colour.js";
import { element, slider } from "./fields.js";
import { tidy } from "./lights.js";
import { freeId } from "./new_light.js";
import { add, scale, sub } from "./vector.js";

const BESIDE = 0.06; // of the scene's size: where a copy stands
const STOPS = 6; // of the multiplier's slider, to either side of 1

export const selectedOf = (state) => state.selection.map((id) => state.light(id));

// Buttons for the selection; show() brings them up to date.
export function actions(state) {
  const button = (text, title, act) => {
    const made = element("button", { type: "button", textContent: text, title });
    made.addEventListener("click", act);
    return made;
  };
  const alone = button("Solo", "All other lights off, and on again (S)", () => solo(state));
  const lock = button("Lock", "Not to be moved, changed or removed (L)", () => toggleLock(state));
  const box = element("div", { className: "buttons" });
  box.append(
    button("Duplicate", "Another one like it, beside it (Ctrl-D)", () => duplicate(state)), alone, lock,
  );
  const show = () => {
    alone.setAttribute("aria-pressed", String(isAlone(state)));
    lock.setAttribute("aria-pressed", String(selectedOf(state).every(({ locked }) => locked)));
  };
  return { row: box, show };
}

// The same fields for all that are selected; of(light) makes those of each.
export function changeSelected(state, of, moving = false) {
  const changes = selectedOf(state).map((light) => [light.id, of(light)]);
  state.changeAll(Object.fromEntries(changes), moving);
}

export function toggleLock(state) {
  const locked = !selectedOf(state).every((light) => light.locked);
  changeSelected(state, () => ({ locked }));
}

export function toggleOn(state) {
  const enabled = !selectedOf(state).every((light) => light.enabled);
  changeSelected(state, () => ({ enabled }));
}

export function duplicate(state) {
  const aside = scale([1, 0, 0], BESIDE * state.scene.diagonal);
  const copies = [];
  for (const light of structuredClone(selectedOf(state))) {
    const id = freeId(state, light.id.replace(/-\d+$/, ""), copies.map((copy) => copy.id), 2);
    const moved = light.position ? { position: add(light.position, aside) } : {};
    copies.push(tidy({ ...light, ...moved, id, locked: false }));
  }
  state.setLights([...state.lights, ...copies], copies.map(({ id }) => id));
}

const remembered = new WeakMap(); // by state: {ids, on}: which lights were on before some were alone

const only = (state, ids) => state.lights.every((light) => light.enabled === ids.includes(light.id));

function isAlone(state) {
  const { ids = [] } = remembered.get(state) ?? {};
  const { selection } = state;
  const those = ids.length === selection.length && selection.every((id) => ids.includes(id));
  return Boolean(ids.length) && those && only(state, ids);
}

export function solo(state) {
  const before = remembered.get(state);
  const switched = (is) =>
    state.setLights(state.lights.map((light) => ({ ...light, enabled: is(light.id) })));
  if (isAlone(state)) {
    remembered.delete(state);
    switched((id) => before.on.has(id));
    return;
  }
  // From some that are alone to others: those that were on before the first.
  const on = before && only(state, before.ids)
    ? before.on
    : new Set(state.lights.filter(({ enabled }) => enabled).map(({ id }) => id));
  const ids = [...state.selection];
  if (!ids.length) return;
  remembered.set(state, { ids, on });
  switched((id) => ids.includes(id));
}

// What the hand does to one light, done to all that are selected: places shift along, sizes grow by
// the same factor. Changes as `state.changeAll` takes them.
export function spread(state, id, fields) {
  const from = state.light(id);
  const changes = { [id]: fields };
  for (const light of selectedOf(state)) {
    if (light.id === id) continue;
    const { properties } = state.scene.light_types[light.type];
    const along = Object.entries(fields)
      .filter(([name]) => name in light && name !== "direction")
      .map(([name, value]) => [name, Array.isArray(value)
        ? add(light[name], sub(value, from[name]))
        : within((light[name] * value) / from[name], properties[name])]);
    changes[light.id] = Object.fromEntries(along);
  }
  return changes;
}

// A number as near as a schema allows.
export function within(value, { minimum, exclusiveMinimum = 0, maximum = Infinity }) {
  return Math.min(maximum, Math.max(minimum ?? exclusiveMinimum + 1e-4, value));
}

// A slider of black bodies' colours, in steps that look alike; the strength stays.
export function temperature(change) {
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
      get: ({ intensity }) => Math.round(temperatureOf(intensity) ?? 6500),
      change: (kelvin, moving) => change(({ intensity }) => {
        const s = strength(intensity);
        return { intensity: ofTemperature(kelvin).map((c) => c * s) };
      }, moving),
    },
  );
}

// A factor on the intensity, which keeps what was set. Pulled, all that are selected gain by the same
// factor; typed, all have the same.
export function multiplier(state, change) {
  const of = ({ multiplier: factor = 1 }) => factor;
  return slider("Multiplier", { min: -STOPS, max: STOPS, step: 0.05 }, "×", {
    title: "Times the intensity; of several lights all gain alike",
    least: 0,
    most: "",
    toSlider: (factor) => Math.log2(Math.max(factor, 1e-12)),
    fromSlider: (stops) => 2 ** stops,
    get: of,
    change: (factor, moving, typed) => {
      const now = of(state.light(state.selected));
      const gain = typed || !(now > 0) ? null : factor / now;
      change((light) => ({ multiplier: gain === null ? factor : of(light) * gain }), moving);
    },
  });
}
