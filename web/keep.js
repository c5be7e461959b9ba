// What a person takes along: the picture as a file, the edits as JSON, all of it as a link.

import { post } from "./materials.js";

const TYPES = { png: "image/png", exr: "image/x-exr" };

export class Keep {
  // problem(detail) shows what is wrong.
  constructor(state, find, { problem }) {
    Object.assign(this, { state, find, problem });
    for (const kind of Object.keys(TYPES)) {
      find(`keep-${kind}`).addEventListener("click", () => this.#savePicture(kind));
    }
    find("keep-edits").addEventListener("click", () => this.#saveEdits());
    find("keep-link").addEventListener("click", () => this.#copyLink());
    const file = find("keep-file");
    find("keep-open").addEventListener("click", () => file.click());
    file.addEventListener("change", () => this.#opened(file));
  }

  // What the page's own address asks for: {scene, method, exposure, settings, edits}, or null.
  static asked() {
    if (location.hash.length < 2) return null;
    try {
      const asked = JSON.parse(decodeURIComponent(location.hash.slice(1)));
      return asked !== null && typeof asked === "object" ? asked : null;
    } catch {
      return null;
    }
  }

  // Take up a whole state; the scene is open already.
  restore({ method, exposure, settings, edits }) {
    this.#telling(() => {
      const { state } = this;
      if (state.scene.methods.some(({ name }) => name === method)) state.setMethod(method);
      if (Number.isFinite(exposure)) state.setExposure(Math.max(-10, Math.min(10, exposure)));
      if (settings && Object.keys(settings).length) state.setSettings(settings);
      this.#take(edits ?? {});
    });
  }

  // Edits, as `relight render --edits` takes them: on top of the scene's own, not of what is here.
  #take({ lights = [], environment, materials = {}, camera }) {
    const { state } = this;
    const { scene } = state;
    const own = structuredClone(scene.lights);
    const kept = own.map((light) => ({ ...light, ...lights.find(({ id }) => id === light.id) }));
    const added = lights.filter(({ id }) => !own.some((light) => light.id === id));
    for (const { id, type } of added) {
      if (!(type in scene.light_types)) throw new Error(`light ${id} has no type that there is`);
    }
    const complete = ({ type }) => Object.fromEntries(
      Object.entries(scene.light_types[type].properties)
        .filter(([, schema]) => schema.default !== undefined)
        .map(([name, schema]) => [name, schema.default]),
    );
    const description = structuredClone(scene.environment.description);
    state.restore({
      lights: [...kept, ...added.map((light) => ({ ...complete(light), ...light }))],
      environment: environment ? { rotation_degrees: 0, intensity: 1, ...description, ...environment }
        : description,
      materialEdits: state.takes("materials") ? materials : {},
    });
    if (!state.takes("materials") && Object.keys(materials).length) state.setMaterials(materials);
    state.setCamera({ ...structuredClone(scene.camera), ...camera });
  }

  get #name() {
    return `${this.state.scene.name}-${this.state.method}`;
  }

  async #savePicture(kind) {
    const { scene, exposure, method, settings } = this.state;
    const query = new URLSearchParams({ exposure, method, settings: JSON.stringify(settings) });
    const request = post(this.state.edits());
    request.headers.Accept = TYPES[kind];
    await this.#telling(async () => {
      const path = `api/scenes/${encodeURIComponent(scene.name)}/frame?${query}`;
      const response = await fetch(path, request);
      if (!response.ok) throw new Error((await response.json()).detail);
      this.#save(await response.blob(), `${this.#name}.${kind}`);
    });
  }

  #saveEdits() {
    const text = JSON.stringify(this.state.edits(), null, 1);
    this.#save(new Blob([text], { type: "application/json" }), `${this.#name}.json`);
    this.#tell("relight render --edits takes them, and Open.");
  }

  #save(blob, name) {
    const link = Object.assign(document.createElement("a"), {
      href: URL.createObjectURL(blob), download: name,
    });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
    this.#tell(`${name} is saved.`);
  }

  // The whole state, as `restore` takes it.
  get whole() {
    const { scene, exposure, method, chosen } = this.state;
    const settings = chosen[method] ?? {};
    return { scene: scene.name, method, exposure, settings, edits: this.state.edits() };
  }

  async #copyLink() {
    history.replaceState(null, "", `#${encodeURIComponent(JSON.stringify(this.whole))}`);
    try {
      await navigator.clipboard.writeText(location.href);
      this.#tell("The link is copied.");
    } catch {
      this.#tell("The page's address is the link now.");
    }
  }

  async #opened(file) {
    const [chosen] = file.files;
    file.value = "";
    if (!chosen) return;
    await this.#telling(async () => {
      this.#take(JSON.parse(await chosen.text()));
      this.#tell(`${chosen.name} is opened.`);
    });
  }

  async #telling(work) {
    try {
      await work();
    } catch (error) {
      this.problem(`That cannot be taken up: ${error.message}`);
    }
  }

  #tell(text) {
    this.find("keep-told").textContent = text;
  }
}
