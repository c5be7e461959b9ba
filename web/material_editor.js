// Materials under the hand, for a method that takes edits of them: type, colours, sharpness.

import { strength, withStrength } from "./colour.js";
import { copyButton } from "./copy.js";
import { curveEditor } from "./curve_editor.js";
import { colour, element, field, group, slider, words } from "./fields.js";
import { byHand, modelsFor } from "./follow.js";
import { Gallery } from "./gallery.js";
import { asText, defaults, kind, madeOf, swatch } from "./material_words.js";
import { post } from "./materials.js";

const HIDDEN = new Set(["type", "emission"]);
const SHARPEST = 1e4; // of the sliders; larger exponents are typed
const EVEN = 20; // numbers up to this have a slider of their own, larger ones of their logarithms
const OFF = 0.05; // mean relative error of a code that is marked, as the service warns

export class MaterialEditor {
  #own = {}; // the scene's, by name
  #selected = null;
  #built = "";
  #fields = [];
  #fits = {}; // how the method models them, by name
  #scene = null;
  #opened = null; // what the list and the controls are for

  // call(path, options) asks the service; thumbnail(material) and sendMeasured(file) see `Gallery`.
  constructor(state, { part, list, box, reset }, { call, thumbnail, sendMeasured }) {
    Object.assign(this, { state, part, list, box, resetButton: reset, call });
    this.gallery = new Gallery(state, {
      ask: thumbnail,
      send: sendMeasured,
      choose: (material) => this.#choose(material),
      drawn: () => this.draw(),
    });
    this.made = element("p", { className: "made" });
    reset.addEventListener("click", () => state.setMaterialEdits({}));
  }

  // The scene or the method is another one. What a method that stands still with its materials shows
  // can be taken in hand too: another method goes on from there, with the same controls.
  async open() {
    const { state } = this;
    this.part.hidden = !byHand(state);
    if (this.part.hidden) return;
    this.models = modelsFor(state);
    const opened = `${state.scene.name} ${this.models}`;
    if (opened !== this.#opened || this.#scene !== state.scene) await this.#fill();
    this.#opened = opened;
    this.refit();
    if (state.takes("materials")) state.hold(this.#selected);
  }

  async #fill() {
    const found = await this.#ask("materials", {});
    if (!found) return;
    this.#own = Object.fromEntries(found.map(({ name, description }) => [name, description]));
    if (!(this.#selected in this.#own)) this.#selected = found[0]?.name ?? null;
    this.list.replaceChildren(...found.map(({ name }) => this.#row(name)));
    if (this.#scene !== this.state.scene) this.gallery.forget();
    this.#scene = this.state.scene;
    if (this.#measures) this.gallery.open(this.models);
    this.#fits = {};
    this.#built = "";
    this.draw();
  }

  // Whether the method takes measured materials, and codes whatever is glossy.
  get #measures() {
    return this.models.includes("measured");
  }

  // The method's product or the materials are others: what does it make of them?
  async refit() {
    if (this.part.hidden || !this.#measures || !this.state.takes("materials")) return;
    const { method, materialEdits } = this.state;
    const { materials = {} } = this.state.edits();
    const found = await this.#ask(`materials?${new URLSearchParams({ method })}`, { materials });
    if (!found || method !== this.state.method || materialEdits !== this.state.materialEdits) return;
    this.#fits = Object.fromEntries(found.map((fit) => [fit.name, fit]));
    this.draw();
  }

  // Take in hand what the picture shows at (x, y).
  async pick(x, y) {
    const { camera } = this.state.edits();
    const seen = await this.#ask(`pick?x=${x}&y=${y}`, camera ? { camera } : {});
    if (seen?.material) this.#select(seen.material);
  }

  // What the service answers; null where it does not, or another scene has been opened meanwhile.
  async #ask(what, edits) {
    const { scene } = this.state;
    try {
      const path = `api/scenes/${encodeURIComponent(scene.name)}/${what}`;
      const answer = await this.call(path, post(edits));
      return scene === this.state.scene ? answer : null;
    } catch {
      return null; // told beside the picture
    }
  }

  #select(name) {
    this.#selected = name;
    this.draw();
    this.state.hold(name);
    const row = [...this.list.children].find(({ dataset }) => dataset.name === name);
    row?.scrollIntoView({ block: "nearest" });
    this.box.scrollIntoView({ block: "nearest" });
  }

  draw() {
    if (this.part.hidden || !this.#selected) return;
    const { state } = this;
    this.resetButton.disabled = !Object.keys(state.materialEdits).length;
    for (const row of this.list.children) {
      const material = this.#material(row.dataset.name);
      row.classList.toggle("selected", row.dataset.name === this.#selected);
      const url = material.type === "measured" ? this.gallery.known(material.file) : null;
      const background = url ? `url(${url}) center / cover` : swatch(material);
      row.querySelector(".swatch").style.background = background;
      row.querySelector(".name").setAttribute("aria-pressed", row.dataset.name === this.#selected);
      row.querySelector(".kind").textContent = kind(material.type);
    }
    const material = this.#material(this.#selected);
    const key = `${this.#selected} ${material.type}`;
    // Inputs are kept while a material stays selected, so that focus and drags survive.
    if (key !== this.#built) this.#build(material);
    this.#built = key;
    for (const show of this.#fields) show(material);
    this.made.textContent = this.#measures ? madeOf(this.#fits[this.#selected]) : "";
    this.made.classList.toggle("off", this.#fits[this.#selected]?.error > OFF);
    this.gallery.show(material);
  }

  #material(name) {
    return this.state.materialEdits[name] ?? this.#own[name];
  }

  #row(name) {
    const row = element("li", {});
    row.dataset.name = name;
    const button = element("button", { type: "button", className: "name", textContent: name });
    button.addEventListener("click", () => this.#select(name));
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
    const name = this.#selected;
    const title = element("h3", { textContent: name });
    const copy = copyButton(() => asText({ [name]: this.#material(name) }), title);
    copy.title = "as JSON, for the materials of a scene or of edits";
    const reset = element("button", { type: "button", textContent: "Reset" });
    reset.addEventListener("click", () => {
      const { [name]: _, ...rest } = this.state.materialEdits;
      this.state.setMaterialEdits(rest);
    });
    const buttons = element("span", { className: "buttons" });
    buttons.append(copy, reset);
    title.append(buttons);
    this.made.title = "Size of the wavelet code, its mean relative error, and how many tiles it has";
    this.box.replaceChildren(title, this.made);
    if (this.#measures) this.box.append(this.gallery.box);
    else this.#measured();
    this.#kind(material);
    const { properties } = this.state.scene.material_types[material.type] ?? { properties: {} };
    for (const [property, schema] of Object.entries(properties)) {
      if (HIDDEN.has(property)) continue;
      if (schema.minItems > 3) this.#curve(property, schema);
      else if (schema.prefixItems) this.#reflectance(property, schema);
      else if (schema.type === "number") this.#number(property, schema);
      else if (schema.enum) this.#choice(property, schema);
    }
  }

  // The way to those that another method has.
  #measured() {
    const { state } = this;
    const method = state.scene.methods.find(({ models, edits }) =>
      models.includes("measured") && edits.includes("materials"));
    if (!method) return;
    const button = element("button", { type: "button", textContent: "Measured materials …" });
    button.addEventListener("click", () => state.setMethod(method.name));
    const row = element("div", { className: "buttons" });
    row.append(button);
    this.box.append(row);
  }

  // Another type, or a material that is known by name.
  #kind({ type }) {
    const { material_types: types, material_presets: presets } = this.state.scene;
    const known = Object.assign({}, ...Object.values(presets));
    const select = element("select", {});
    const names = [...new Set([...this.models, type])];
    const option = (name) => new Option(name, `preset ${name}`);
    const able = (members) => Object.keys(members).filter((name) => names.includes(known[name].type));
    select.append(
      group("Type", names.map((name) => new Option(kind(name), name))),
      ...Object.entries(presets).map(([label, members]) => group(label, able(members).map(option))),
    );
    select.addEventListener("change", async () => {
      const name = this.#selected;
      const { emission } = this.#own[name];
      const preset = known[select.value.replace(/^preset /, "")];
      const start = preset ?? (await this.#start(types[select.value]));
      if (start && name === this.#selected) this.#set({ ...start, emission }, false);
    });
    this.#add({
      row: field("Type", select),
      show: ({ emission: _, ...now }) => {
        const text = JSON.stringify(now);
        const name = Object.keys(known).find((each) => JSON.stringify(known[each]) === text);
        select.value = name ? `preset ${name}` : now.type;
      },
    });
  }

  // From the gallery: a measured one keeps the colour that multiplies the one before.
  #choose(material) {
    const { emission } = this.#own[this.#selected];
    const old = this.#material(this.#selected);
    const start = defaults(this.state.scene.material_types[material.type]);
    const kept = old.type === "measured" && material.type === "measured" ? { specular: old.specular } : {};
    this.#set({ ...start, ...kept, ...material, emission }, false);
  }

  #add({ row, show }) {
    this.box.append(row);
    this.#fields.push(show);
  }

  // What a type starts from: one with a curve from the material as it is.
  async #start(type) {
    if (!type.properties.curve) return defaults(type);
    const found = await this.#ask("materials", { materials: this.state.materialEdits });
    return found?.find(({ name }) => name === this.#selected)?.curve;
  }

  #curve(name, schema) {
    const change = (values, moving) => this.#change({ [name]: values }, moving);
    const { box, show } = curveEditor(words(name), schema, change);
    this.#add({ row: box, show: (now) => show(now[name]) });
  }

  // One of a few words.
  #choice(name, { description: title, enum: choices }) {
    const select = element("select", { title });
    select.append(...choices.map((choice) => new Option(words(choice), choice)));
    select.addEventListener("change", () => this.#change({ [name]: select.value }, false));
    this.#add({ row: field(words(name), select), show: (now) => (select.value = now[name]) });
  }

  // Its colour, and how much of the light it is.
  #reflectance(name, { description: title }) {
    const change = (value, moving) => this.#change({ [name]: value }, moving);
    this.#add(colour(`${words(name)} colour`, { get: (now) => now[name], change, title }));
    // A hand that passes through black does not lose the colour there.
    let last = [0, 0, 0];
    this.#add(slider(words(name), { min: 0, max: 100, step: 0.5 }, "%", {
      title,
      get: ({ [name]: now }) => {
        if (strength(now)) last = now;
        return 100 * strength(now);
      },
      change: (percent, moving) => change(withStrength(last, percent / 100), moving),
    }));
  }

  // Exponents reach over decades, so their slider is of logarithms.
  #number(name, { description: title, minimum: least = 0, maximum: most = 1 }) {
    const how = {
      title, least, most,
      get: (now) => now[name],
      change: (value, moving) => this.#change({ [name]: value }, moving),
    };
    if (most <= EVEN) {
      const step = Math.max(0.005, (most - least) / 200);
      this.#add(slider(words(name), { min: least, max: most, step }, "", how));
      return;
    }
    const max = Math.log10(Math.min(most, SHARPEST));
    this.#add(slider(words(name), { min: 0, max, step: 0.01 }, "", {
      ...how,
      toSlider: (exponent) => Math.log10(Math.max(1, exponent)),
      fromSlider: (place) => 10 ** place,
    }));
  }
}
