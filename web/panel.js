// The lights' side: a list with switches, and every number of the selected light.

import { strength, toHex, withStrength } from "./colour.js";
import { capital, colour, element, field, number, words } from "./fields.js";
import { actions, temperature } from "./light_actions.js";

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
  #rows = "";

  constructor(state, { list, light, add, reset }) {
    Object.assign(this, { state, list, box: light, add, resetButton: reset });
    add.addEventListener("change", () => {
      if (add.value) state.addLight(add.value);
      add.value = "";
    });
    reset.addEventListener("click", () => state.reset());
  }

  open() {
    const types = Object.keys(this.state.scene.light_types);
    this.add.replaceChildren(
      new Option("Add …", ""),
      ...types.map((type) => new Option(`${capital(type)} light`, type)),
    );
    this.#built = this.#rows = "";
    this.draw();
  }

  draw() {
    this.resetButton.disabled = !this.state.changed;
    this.#drawList();
    const light = this.state.light(this.state.selected);
    // Inputs are kept while a light stays selected, so that focus and drags survive.
    const key = light ? `${light.id} ${light.type}` : "";
    if (key !== this.#built) this.#build(light);
    this.#built = key;
    if (light) for (const show of this.#fields) show(light);
  }

  #drawList() {
    const { state } = this;
    const rows = state.lights.map((light) => light.id).join("\n");
    if (rows !== this.#rows || !this.list.children.length) {
      this.#rows = rows;
      this.list.replaceChildren(...state.lights.map((light) => this.#row(light.id)));
      if (!state.lights.length) {
        this.list.append(element("li", { className: "empty", textContent: "No lights yet: add one." }));
      }
    }
    for (const [index, light] of state.lights.entries()) {
      const row = this.list.children[index];
      row.classList.toggle("selected", light.id === state.selected);
      row.querySelector("input").checked = light.enabled;
      row.querySelector(".swatch").style.background = light.enabled
        ? toHex(light.intensity)
        : "transparent";
      row.querySelector(".name").setAttribute("aria-pressed", light.id === state.selected);
    }
  }

  #row(id) {
    const { state } = this;
    const row = element("li", {});
    const on = element("input", { type: "checkbox", title: `${id} on or off` });
    on.setAttribute("aria-label", `${id} on`);
    on.addEventListener("change", () => state.change(id, { enabled: on.checked }));
    const name = element("button", { type: "button", className: "name", textContent: id });
    name.addEventListener("click", () => state.select(id));
    const kind = element("span", { className: "kind", textContent: state.light(id).type });
    row.append(on, element("span", { className: "swatch" }), name, kind);
    return row;
  }

  #build(light) {
    this.#fields = [];
    this.box.replaceChildren();
    if (!light) return;
    const { state } = this;
    const { id } = light;
    const change = (fields, moving) => state.change(id, fields, moving);
    const title = element("h3", { textContent: id });
    const own = state.isOwn(id);
    const undo = element("button", { type: "button", textContent: own ? "Remove" : "Reset" });
    undo.addEventListener("click", () => (own ? state.removeLight(id) : state.reset(id)));
    title.append(undo);
    this.box.append(title);
    this.#shown(actions(state, id));

    this.#colour(change);
    this.#shown(temperature(change));
    this.#intensity(light, change);
    const { properties } = state.scene.light_types[light.type];
    for (const [name, schema] of Object.entries(properties)) {
      if (SHOWN.has(name)) continue;
      if (schema.type === "array") this.#numbers(name, schema, change);
      else if (schema.type === "boolean") this.#switch(name, schema, change);
      else if (schema.type === "string") this.#text(name, schema, change);
      else if (schema.type === "number" || schema.type === "integer") {
        this.#number(name, schema, change);
      }
    }
  }

  #field(label, control, unit = "") {
    this.box.append(field(label, control, unit));
  }

  #colour(change) {
    const { row, show } = colour("Colour", {
      get: ({ intensity }) => intensity,
      change: (intensity, moving) => change({ intensity }, moving),
      dark: 0,
    });
    this.#shown({ row, show });
  }

  #shown({ row, show }) {
    this.box.append(row);
    this.#fields.push(show);
  }

  #intensity(original, change) {
    const { state } = this;
    const old = state.scene.lights.find((light) => light.id === original.id) ?? original;
    const middle = Math.log10(strength(old.intensity) || 1);
    const slider = element("input", {
      type: "range", min: middle - DECADES, max: middle + DECADES, step: 0.01,
    });
    const exact = element("input", { type: "number", min: 0, step: "any" });
    exact.setAttribute("aria-label", "Intensity, exact");
    let light = null;
    const set = (s, moving) => change({ intensity: withStrength(light.intensity, s) }, moving);
    slider.addEventListener("input", () => set(10 ** slider.valueAsNumber, true));
    slider.addEventListener("change", () => set(10 ** slider.valueAsNumber, false));
    exact.addEventListener("change", () => {
      if (exact.valueAsNumber >= 0) set(exact.valueAsNumber, false);
    });
    this.#field("Intensity", slider);
    const row = element("div", { className: "field" });
    const cell = element("span", { className: "unit" });
    cell.append(exact, element("small", { textContent: UNITS[original.type] ?? "" }));
    row.append(element("span", {}), cell);
    this.box.append(row);
    this.#fields.push((now) => {
      light = now;
      const s = strength(now.intensity);
      if (document.activeElement !== slider) slider.value = Math.log10(Math.max(s, 1e-12));
      slider.setAttribute("aria-valuetext", `${number(s)} ${UNITS[now.type] ?? ""}`);
      if (document.activeElement !== exact) exact.value = number(s);
    });
  }

  #number(name, schema, change) {
    const angle = name.endsWith("_degrees");
    const input = element("input", { type: "number", step: angle ? 1 : "any" });
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
    this.#field(words(name), input, angle ? "°" : BARE.test(name) ? "" : "m");
    this.#fields.push((now) => {
      if (document.activeElement !== input) input.value = number(now[name]);
    });
  }

  #switch(name, schema, change) {
    const input = element("input", { type: "checkbox", title: schema.description ?? "" });
    input.addEventListener("change", () => change({ [name]: input.checked }, false));
    this.#field(words(name), input);
    this.#fields.push((now) => {
      input.checked = now[name];
    });
  }

  #text(name, schema, change) {
    const input = element("input", { type: "text", title: schema.description ?? "" });
    input.addEventListener("change", () => change({ [name]: input.value.trim() }, false));
    this.#field(words(name), input);
    this.#fields.push((now) => {
      if (document.activeElement !== input) input.value = now[name];
    });
  }

  #numbers(name, schema, change) {
    const box = element("span", { className: "triple" });
    let values = [0, 0, 0];
    const inputs = AXES.slice(0, schema.prefixItems?.length ?? 3).map((axis, index) => {
      const input = element("input", { type: "number", step: "any" });
      input.setAttribute("aria-label", `${words(name)} ${axis}`);
      input.title = `${axis}: ${schema.description ?? words(name)}`;
      input.addEventListener("change", () => {
        if (Number.isNaN(input.valueAsNumber)) return;
        change({ [name]: values.map((v, i) => (i === index ? input.valueAsNumber : v)) }, false);
      });
      return input;
    });
    box.append(...inputs);
    this.#field(words(name), box);
    this.#fields.push((now) => {
      values = now[name];
      inputs.forEach((input, i) => {
        if (document.activeElement !== input) input.value = String(Number(values[i].toFixed(3)));
      });
    });
  }
}
