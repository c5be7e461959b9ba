// Materials under the hand, for a method that takes edits of them: type, colours, sharpness.

import { fromHex, strength, toHex, withStrength } from "./colour.js";
import { curveEditor } from "./curve_editor.js";
import { capital, element, field, number, words } from "./fields.js";
import { post } from "./materials.js";

const HIDDEN = new Set(["type", "emission"]);

export class MaterialEditor {
  #own = {}; // the scene's, by name
  #selected = null;
  #built = "";
  #fields = [];

  // call(path, options) asks the service.
  constructor(state, { part, list, box, reset }, call) {
    Object.assign(this, { state, part, list, box, resetButton: reset, call });
    reset.addEventListener("click", () => state.setMaterialEdits({}));
  }

  // The scene or the method is another one.
  async open() {
    const { state } = this;
    this.part.hidden = !state.takes("materials");
    if (this.part.hidden) return;
    const { scene } = state;
    const path = `api/scenes/${encodeURIComponent(scene.name)}/materials`;
    let found = null;
    try {
      found = await this.call(path, post({}));
    } catch {
      return;
    }
    if (scene !== state.scene) return;
    this.#own = Object.fromEntries(found.map(({ name, description }) => [name, description]));
    if (!(this.#selected in this.#own)) this.#selected = found[0]?.name ?? null;
    this.list.replaceChildren(...found.map(({ name }) => this.#row(name)));
    this.#built = "";
    this.draw();
  }

  draw() {
    if (this.part.hidden || !this.#selected) return;
    const { state } = this;
    this.resetButton.disabled = !Object.keys(state.materialEdits).length;
    for (const row of this.list.children) {
      const material = this.#material(row.dataset.name);
      row.classList.toggle("selected", row.dataset.name === this.#selected);
      row.querySelector(".swatch").style.background = picked(material.diffuse ?? [0.5, 0.5, 0.5]);
      row.querySelector(".name").setAttribute("aria-pressed", row.dataset.name === this.#selected);
      row.querySelector(".kind").textContent = kind(material.type);
    }
    const material = this.#material(this.#selected);
    const key = `${this.#selected} ${material.type}`;
    // Inputs are kept while a material stays selected, so that focus and drags survive.
    if (key !== this.#built) this.#build(material);
    this.#built = key;
    for (const show of this.#fields) show(material);
  }

  #material(name) {
    return this.state.materialEdits[name] ?? this.#own[name];
  }

  #row(name) {
    const row = element("li", {});
    row.dataset.name = name;
    const button = element("button", { type: "button", className: "name", textContent: name });
    button.addEventListener("click", () => {
      this.#selected = name;
      this.draw();
    });
    row.append(element("span", { className: "swatch" }), button);
    row.append(element("span", { className: "kind" }));
    return row;
  }

  #set(material, moving) {
    const { state } = this;
    const edits = { ...state.materialEdits, [this.#selected]: material };
    state.setMaterialEdits(edits, moving);
  }

  #change(fields, moving) {
    this.#set({ ...this.#material(this.#selected), ...fields }, moving);
  }

  #build(material) {
    this.#fields = [];
    const title = element("h3", { textContent: this.#selected });
    const reset = element("button", { type: "button", textContent: "Reset" });
    const name = this.#selected;
    reset.addEventListener("click", () => {
      const { [name]: _, ...rest } = this.state.materialEdits;
      this.state.setMaterialEdits(rest);
    });
    title.append(reset);
    this.box.replaceChildren(title);
    this.#kind(material);
    const { properties } = this.state.scene.material_types[material.type] ?? { properties: {} };
    for (const [property, schema] of Object.entries(properties)) {
      if (HIDDEN.has(property)) continue;
      if (schema.minItems > 3) this.#curve(property, schema);
      else if (schema.type === "array") this.#colour(property, schema);
      else if (schema.type === "number") this.#number(property, schema);
    }
  }

  // Another type, or a material that is known by name.
  #kind({ type }) {
    const { material_types: types, material_presets: presets } = this.state.scene;
    const select = element("select", {});
    const group = (label, options) => {
      const box = element("optgroup", { label });
      box.append(...options);
      return box;
    };
    const names = Object.keys(types).includes(type) ? Object.keys(types) : [type, ...Object.keys(types)];
    const known = Object.entries(presets).filter(([, preset]) => preset.type in types);
    select.append(
      group("Type", names.map((name) => new Option(kind(name), name))),
      group("Known materials", known.map(([name]) => new Option(name, `preset:${name}`))),
    );
    select.addEventListener("change", async () => {
      const name = this.#selected;
      const { emission } = this.#own[name];
      const preset = presets[select.value.replace(/^preset:/, "")];
      const start = preset ?? (await this.#start(types[select.value]));
      if (name === this.#selected) this.#set({ ...start, emission }, false);
    });
    this.#field("Type", select);
    this.#fields.push((now) => {
      select.value = now.type;
    });
  }

  // What a type starts from: one with a curve from the material as it is.
  async #start(type) {
    if (!type.properties.curve) return defaults(type);
    const { scene, materialEdits: materials } = this.state;
    const path = `api/scenes/${encodeURIComponent(scene.name)}/materials`;
    const found = await this.call(path, post({ materials }));
    return found.find(({ name }) => name === this.#selected).curve;
  }

  #curve(name, schema) {
    const change = (values, moving) => this.#change({ [name]: values }, moving);
    const { box, show } = curveEditor(words(name), schema, change);
    this.box.append(box);
    this.#fields.push((now) => show(now[name]));
  }

  #field(label, control, unit = "") {
    this.box.append(field(label, control, unit));
  }

  // A reflectance: its colour, and how much of the light it is.
  #colour(name, schema) {
    const input = element("input", { type: "color", title: schema.description ?? "" });
    const slider = element("input", { type: "range", min: 0, max: 1, step: 0.005 });
    slider.setAttribute("aria-label", `${words(name)}, how much`);
    let value = [0, 0, 0];
    const pick = (moving) => this.#change({ [name]: fromHex(input.value, strength(value)) }, moving);
    const dim = (moving) =>
      this.#change({ [name]: withStrength(value, slider.valueAsNumber) }, moving);
    input.addEventListener("input", () => pick(true));
    input.addEventListener("change", () => pick(false));
    slider.addEventListener("input", () => dim(true));
    slider.addEventListener("change", () => dim(false));
    const box = element("span", { className: "pair" });
    box.append(input, slider);
    this.#field(words(name), box);
    this.#fields.push((now) => {
      value = now[name];
      if (document.activeElement !== input) input.value = toHex(value);
      if (document.activeElement !== slider) slider.value = strength(value);
      slider.setAttribute("aria-valuetext", `${(100 * strength(value)).toFixed(0)} %`);
    });
  }

  // Exponents reach over decades, so their slider is of logarithms.
  #number(name, schema) {
    const log = (schema.maximum ?? 1) > 10;
    const most = Math.min(schema.maximum ?? 1, 1e4);
    const to = log ? (x) => Math.log10(Math.max(1, x)) : (x) => x;
    const from = log ? (x) => 10 ** x : (x) => x;
    const slider = element("input", {
      type: "range", min: to(schema.minimum ?? 0), max: to(most), step: log ? 0.01 : 0.005,
      title: schema.description ?? "",
    });
    slider.setAttribute("aria-label", words(name));
    const shown = element("output", {});
    const change = (moving) => this.#change({ [name]: from(slider.valueAsNumber) }, moving);
    slider.addEventListener("input", () => change(true));
    slider.addEventListener("change", () => change(false));
    const box = element("span", { className: "pair" });
    box.append(slider, shown);
    this.#field(words(name), box);
    this.#fields.push((now) => {
      if (document.activeElement !== slider) slider.value = to(now[name]);
      shown.textContent = number(now[name]);
    });
  }
}

const kind = (type) => capital(type.replaceAll("_", "-"));

const picked = (rgb) => toHex(rgb.map((c) => Math.min(1, c)));

function defaults({ properties }) {
  const pairs = Object.entries(properties).filter(([, schema]) => schema.default !== undefined);
  return Object.fromEntries(pairs.map(([name, schema]) => [name, schema.default]));
}
