// Materials to choose by their picture: measured ones and models, each as a lit ball. A file is read
// when it is first seen in the list, one after the other: that takes the service seconds.

import { capital, element } from "./fields.js";

const HEADINGS = { built_in: "Measured", beside: "Measured", upload: "Opened" };
const MODELS = "Models";
const KIND = /\.(brdf|binary|csv)$/i;

export class Gallery {
  #tiles = [];
  #pictures = new Map(); // by material in JSON: {url} or {problem}
  #waiting = [];
  #busy = false;
  #wanted = null; // what was chosen last and may still be read
  #seen = null;

  // ask(material) resolves to a blob, send(file) to what the service calls it, choose(material) takes
  // one, drawn() hears of new pictures.
  constructor(state, { ask, send, choose, drawn }) {
    Object.assign(this, { state, ask, send, choose, drawn });
    this.box = element("div", { className: "gallery" });
    this.list = element("div", { className: "tiles" });
    this.list.setAttribute("role", "group");
    this.list.setAttribute("aria-label", "Materials to choose");
    this.told = element("ul", { className: "notices" });
    this.told.setAttribute("role", "status");
    this.file = element("input", { type: "file", accept: ".brdf,.binary,.csv", hidden: true });
    this.file.setAttribute("aria-label", "Measured material to open");
    this.opener = element("button", {
      type: "button", textContent: "Open …",
      title: "A measured material of yours: a goniometer's .brdf, MERL's .binary, or a table in .csv",
    });
    this.opener.addEventListener("click", () => this.file.click());
    this.file.addEventListener("change", () => this.#opened());
    const foot = element("div", { className: "foot" });
    foot.append(this.opener, element("small", { textContent: "measured: .brdf, .binary, .csv" }));
    this.box.append(this.list, foot, this.file, this.told);
    this.#seen = new IntersectionObserver((entries) => this.#appeared(entries), { root: this.list });
  }

  // Another scene, or another method; models are types that it takes.
  open(models) {
    this.#waiting = [];
    this.#wanted = null;
    this.told.replaceChildren();
    this.#build(models);
  }

  #build(models = this.models) {
    this.models = models;
    this.#seen.disconnect();
    this.#tiles = [];
    const groups = new Map();
    const add = (heading, material, label) => {
      if (!groups.has(heading)) groups.set(heading, []);
      groups.get(heading).push(this.#tile(material, label));
    };
    const { measured } = this.state.scene;
    for (const { name, label, kind } of measured) {
      add(HEADINGS[kind], { type: "measured", file: name }, label);
    }
    for (const type of models) {
      if (type !== "measured") add(MODELS, { type }, capital(type.replaceAll("_", " ")));
    }
    this.list.replaceChildren();
    for (const [heading, tiles] of groups) {
      this.list.append(element("h4", { textContent: heading }), ...tiles);
    }
    for (const { node } of this.#tiles) this.#seen.observe(node);
  }

  #tile(material, label) {
    const node = element("button", { type: "button", className: "tile", title: label });
    node.dataset.name = material.file ?? material.type;
    node.append(element("span", { className: "ball" }), element("small", { textContent: label.replace(KIND, "") }));
    node.addEventListener("click", () => this.#chosen(tile));
    const tile = { material, node, label };
    this.#tiles.push(tile);
    this.#show(tile);
    return node;
  }

  // The material in the hand.
  show(now) {
    for (const { material, node } of this.#tiles) {
      const is = material.file ? material.file === now.file : material.type === now.type;
      node.setAttribute("aria-pressed", String(is && material.type === now.type));
    }
  }

  // Where the picture of a measured material is; null where there is none yet, which is then asked for.
  known(file) {
    const material = { type: "measured", file };
    const { url = null } = this.#pictures.get(key(material)) ?? {};
    if (!this.#pictures.has(key(material))) this.#want(material);
    return url;
  }

  async #chosen(tile) {
    const { material, node } = tile;
    const { hand } = this.state;
    this.#wanted = tile;
    this.told.replaceChildren();
    // It is read first, so that the pictures of what is there go on meanwhile.
    node.setAttribute("aria-busy", "true");
    const { url, problem } = await this.#want(material, true);
    node.removeAttribute("aria-busy");
    // The hand may have turned to something else.
    if (this.#wanted !== tile || this.state.hand !== hand) return;
    if (url) this.choose(material);
    else this.#tell([problem], true);
  }

  #appeared(entries) {
    for (const { isIntersecting, target } of entries) {
      if (!isIntersecting) continue;
      this.#seen.unobserve(target);
      this.#want(this.#tiles.find(({ node }) => node === target).material);
    }
  }

  // Resolves to a picture or a problem; one that somebody waits for comes first.
  #want(material, first = false) {
    const known = this.#pictures.get(key(material));
    if (known) return Promise.resolve(known);
    const old = this.#waiting.find((each) => key(each.material) === key(material));
    const job = old ?? { material, takers: [] };
    if (!old || first) {
      this.#waiting = this.#waiting.filter((each) => each !== job);
      this.#waiting[first ? "unshift" : "push"](job);
    }
    const done = new Promise((resolve) => job.takers.push(resolve));
    this.#next();
    return done;
  }

  async #next() {
    if (this.#busy || !this.#waiting.length) return;
    this.#busy = true;
    const { material, takers } = this.#waiting.shift();
    const { scene } = this.state;
    let found = null;
    try {
      found = { url: URL.createObjectURL(await this.ask(material)) };
    } catch (error) {
      found = { problem: error.message };
    }
    this.#busy = false;
    for (const take of takers) take(found);
    if (scene === this.state.scene) {
      this.#pictures.set(key(material), found);
      for (const tile of this.#tiles) this.#show(tile);
      this.drawn();
    }
    this.#next();
  }

  #show({ material, node, label }) {
    const found = this.#pictures.get(key(material));
    if (!found) return;
    node.title = found.problem ? `${label}: ${found.problem}` : label;
    node.classList.toggle("broken", Boolean(found.problem));
    if (found.url) node.querySelector(".ball").style.backgroundImage = `url(${found.url})`;
    node.classList.add("drawn");
  }

  // Another scene has other files.
  forget() {
    for (const { url } of this.#pictures.values()) if (url) URL.revokeObjectURL(url);
    this.#pictures.clear();
  }

  async #opened() {
    const [chosen] = this.file.files;
    if (!chosen) return;
    const { textContent: usual } = this.opener;
    const { scene } = this.state;
    Object.assign(this.opener, { disabled: true, textContent: "Reading …" });
    this.told.replaceChildren();
    try {
      const { material, diagnoses } = await this.send(chosen);
      const { measured } = scene;
      if (!measured.some(({ name }) => name === material.name)) measured.push(material);
      if (scene !== this.state.scene) return;
      this.#build();
      const tile = this.#tiles.find(({ node }) => node.dataset.name === material.name);
      tile.node.scrollIntoView({ block: "nearest" });
      await this.#chosen(tile);
      this.#tell(diagnoses.map(({ message }) => message));
    } catch (error) {
      this.#tell([error.message], true);
    } finally {
      Object.assign(this.opener, { disabled: false, textContent: usual });
      this.file.value = "";
    }
  }

  #tell(messages, bad = false) {
    this.told.classList.toggle("bad", bad);
    this.told.replaceChildren(...messages.map((text) => element("li", { textContent: capital(text) })));
  }
}

const key = (material) => JSON.stringify(material);
