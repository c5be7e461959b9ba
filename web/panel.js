// Every number of the lights that are selected: where they differ nothing is shown, and what is set
// there is set for all of them.

import { strength, withStrength } from "./colour.js";
import {
  capital, colour, differ, element, field, group, mark, number, showNumber, words,
} from "./fields.js";
import { actions, changeSelected, multiplier, selectedOf, temperature } from "./light_actions.js";
import { addPreset, PRESETS } from "./light_presets.js";
import { newLight } from "./new_light.js";

const [INTENSITY, RADIANCE, IRRADIANCE] = ["W/sr", "W/(sr·m²)", "W/m²"];
const UNITS = {
  point: INTENSITY, spot: INTENSITY, projector: INTENSITY,
  area: RADIANCE, disk: RADIANCE, sphere: RADIANCE,
  distant: IRRADIANCE, sun: IRRADIANCE, uberlight: IRRADIANCE,
};
const BARE = /(_exponent|^roundness|^most)$/; // numbers without a unit
const DECADES = 3; // of the intensity slider, to either side
const SHOWN = new Set(["id", "type", "enabled", "intensity"]);
const AXES = ["x", "y", "z"];

export class Panel {
  #built = "";
  #fields = [];

  constructor(state, { light, add, reset }) {
    Object.assign(this, { state, box: light, add, resetButton: reset });
    add.addEventListener("change", () => {
      const [kind, name] = add.value.split(" ");
      if (kind === "preset") addPreset(state, name);
      else if (kind) {
        const light = newLight(state, kind);
        state.setLights([...state.lights, light], [light.id]);
      }
      add.value = "";
    });
    reset.addEventListener("click", () => state.reset());
  }

  open() {
    const types = Object.keys(this.state.scene.light_types);
    this.add.replaceChildren(
      new Option("Add …", ""),
      group("Presets", Object.entries(PRESETS).map(([name, { label }]) => new Option(label, `preset ${name}`))),
      group("One light", types.map((type) => new Option(`${capital(type)} light`, type))),
    );
    this.#built = "";
    this.draw();
  }

  draw() {
    const { state } = this;
    this.resetButton.disabled = !state.changed;
    const lights = selectedOf(state);
    // Inputs are kept while the same lights stay selected, so that focus and drags survive.
    const key = lights.map(({ id, type }) => `${id} ${type}`).join("\n");
    if (key !== this.#built) this.#build(lights);
    this.#built = key;
    if (!lights.length) return;
    const locked = lights.every((light) => light.locked);
    this.values.disabled = locked;
    this.undo.disabled = locked;
    this.note.hidden = !locked;
    for (const show of this.#fields) show(lights.at(-1), lights);
  }

  #build(lights) {
    this.#fields = [];
    this.box.replaceChildren();
    if (!lights.length) return;
    const { state } = this;
    const change = (fields, moving) =>
      changeSelected(state, typeof fields === "function" ? fields : () => fields, moving);
    this.#title(lights);
    this.values = element("fieldset", { className: "values" });
    this.values.setAttribute("aria-label", "Values");
    this.#shown(actions(state), this.box);
    this.note = element("p", { className: "hint", textContent: "Locked: it can only be switched." });
    this.box.append(this.note, this.values);

    this.#colour(change);
    this.#shown(temperature(change));
    this.#intensity(lights, change);
    this.#shown(multiplier(state, change));
    const { properties } = state.scene.light_types[lights.at(-1).type];
    for (const [name, schema] of Object.entries(properties)) {
      // What all of them have.
      if (SHOWN.has(name) || !lights.every((light) => name in light)) continue;
      if (schema.type === "array") this.#numbers(name, schema, change);
      else if (schema.type === "boolean") this.#switch(name, schema, change);
      else if (schema.type === "string") this.#text(name, schema, change);
      else if (schema.type === "number" || schema.type === "integer") {
        this.#number(name, schema, change);
      }
    }
  }

  #title(lights) {
    const { state } = this;
    const ids = lights.map(({ id }) => id);
    const several = lights.length > 1 ? `${lights.length} lights` : ids[0];
    const title = element("h3", { textContent: several, title: ids.join(", ") });
    // Added lights have nothing to go back to.
    const given = ids.filter((id) => !state.isOwn(id));
    const own = !given.length;
    this.undo = element("button", { type: "button", textContent: own ? "Remove" : "Reset" });
    this.undo.addEventListener("click", () => (own ? state.remove(ids) : state.reset(given)));
    title.append(this.undo);
    this.box.append(title);
  }

  #field(label, control, unit = "") {
    const row = field(label, control, unit);
    this.values.append(row);
    return row;
  }

  #colour(change) {
    this.#shown(colour("Colour", {
      get: ({ intensity }) => intensity,
      change: (rgb, moving) =>
        change(({ intensity }) => ({ intensity: withStrength(rgb, strength(intensity)) }), moving),
      dark: 1,
    }));
  }

  #shown({ row, show }, box = this.values) {
    box.append(row);
    this.#fields.push(show);
  }

  // Pulled, several gain by the same factor; typed, all have the same.
  #intensity(lights, change) {
    const { state } = this;
    const { id, type } = lights.at(-1);
    const unit = UNITS[type] ?? "";
    const old = state.scene.lights.find((light) => light.id === id) ?? lights.at(-1);
    const middle = Math.log10(strength(old.intensity) || 1);
    const slider = element("input", {
      type: "range", min: middle - DECADES, max: middle + DECADES, step: 0.01,
    });
    const exact = element("input", { type: "number", min: 0, step: "any" });
    exact.setAttribute("aria-label", "Intensity, exact");
    let now = 1;
    const set = (s) => ({ intensity }) => ({ intensity: withStrength(intensity, s) });
    const pull = (moving) => {
      const s = 10 ** slider.valueAsNumber;
      const gain = s / now;
      change(lights.length > 1 && now > 0
        ? ({ intensity }) => ({ intensity: intensity.map((c) => c * gain) }) : set(s), moving);
    };
    slider.addEventListener("input", () => pull(true));
    slider.addEventListener("change", () => pull(false));
    exact.addEventListener("change", () => {
      if (exact.valueAsNumber >= 0) change(set(exact.valueAsNumber), false);
    });
    this.#field("Intensity", slider);
    const row = element("div", { className: "field" });
    const cell = element("span", { className: "unit" });
    cell.append(exact, element("small", { textContent: unit }));
    row.append(element("span", {}), cell);
    // Of lights of different kinds the numbers cannot be compared.
    if (lights.every((light) => UNITS[light.type] === UNITS[type])) this.values.append(row);
    this.#fields.push((light, all) => {
      now = strength(light.intensity);
      const mixed = differ(all, ({ intensity }) => number(strength(intensity)));
      if (document.activeElement !== slider) slider.value = Math.log10(Math.max(now, 1e-12));
      slider.setAttribute("aria-valuetext", mixed ? "mixed" : `${number(now)} ${unit}`);
      showNumber(exact, now, mixed);
    });
  }

  #number(name, schema, change) {
    // A step would allow only what lies whole steps above the least.
    const input = element("input", { type: "number", step: "any" });
    if (schema.minimum !== undefined) input.min = schema.minimum;
    if (schema.maximum !== undefined) input.max = schema.maximum;
    input.title = schema.description ?? "";
    const set = (moving) => {
      if (input.validity.valid && !Number.isNaN(input.valueAsNumber)) {
        change({ [name]: input.valueAsNumber }, moving);
      }
    };
    input.addEventListener("input", () => set(true));
    input.addEventListener("change", () => set(false));
    const unit = name.endsWith("_degrees") ? "°" : BARE.test(name) ? "" : "m";
    this.#field(words(name), input, unit);
    this.#fields.push((now, all) => showNumber(input, now[name], differ(all, (each) => each[name])));
  }

  #switch(name, schema, change) {
    const input = element("input", { type: "checkbox", title: schema.description ?? "" });
    input.addEventListener("change", () => change({ [name]: input.checked }, false));
    this.#field(words(name), input);
    this.#fields.push((now, all) => {
      input.checked = now[name];
      input.indeterminate = differ(all, (each) => each[name]);
    });
  }

  #text(name, schema, change) {
    const input = element("input", { type: "text", title: schema.description ?? "" });
    input.addEventListener("change", () => change({ [name]: input.value.trim() }, false));
    const row = this.#field(words(name), input);
    this.#fields.push((now, all) => {
      const mixed = differ(all, (each) => each[name]);
      mark(row, input, mixed);
      if (document.activeElement !== input) input.value = mixed ? "" : now[name];
    });
  }

  #numbers(name, schema, change) {
    const box = element("span", { className: "triple" });
    const inputs = AXES.slice(0, schema.prefixItems?.length ?? 3).map((axis, index) => {
      const input = element("input", { type: "number", step: "any" });
      input.setAttribute("aria-label", `${words(name)} ${axis}`);
      input.title = `${axis}: ${schema.description ?? words(name)}`;
      input.addEventListener("change", () => {
        if (Number.isNaN(input.valueAsNumber)) return;
        change((light) => ({ [name]: light[name].with(index, input.valueAsNumber) }), false);
      });
      return input;
    });
    box.append(...inputs);
    this.#field(words(name), box);
    this.#fields.push((now, all) => inputs.forEach((input, i) => {
      const at = (each) => String(Number(each[name][i].toFixed(3)));
      showNumber(input, now[name][i], differ(all, at), at(now));
    }));
  }
}
