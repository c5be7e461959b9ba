// What a person takes along: the picture as a file, the edits as JSON, all of it as a link.

import { marked, marksOf } from "./lights.js";
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

  // What the page's own address asks for, see `whole`, or null.
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
  restore({ method, exposure, settings, edits, others, marks }) {
    this.#telling(() => {
      const { state } = this;
      if (state.scene.methods.some(({ name }) => name === method)) state.setMethod(method);
      if (Number.isFinite(exposure)) state.setExposure(Math.max(-10, Math.min(10, exposure)));
      if (settings && Object.keys(settings).length) state.setSettings(settings);
      this.#take({ ...others, ...edits }, marks ?? {}, others?.materials);
    });
  }

  // Edits, as `relight render --edits` takes them: on top of the scene's own, not of what is here.
  // marks are what they do not say of lights, byHand materials that the method does not show.
  #take({ lights = [], environment, materials = {}, camera }, marks = {}, byHand = null) {
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
    const all = [...kept, ...added.map((light) => ({ ...complete(light), ...light }))];
    state.restore({
      lights: all.map((light) => (marks[light.id] ? marked(light, marks[light.id]) : light)),
      environment: environment ? { rotation_degrees: 0, intensity: 1, ...description, ...environment }
        : description,
      materialEdits: byHand ?? (state.takes("materials") ? materials : {}),
    });
    const made = !state.takes("materials") && !byHand && Object.keys(materials).length;
    if (made) state.setMaterials(materials);
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

  // The whole state, as `restore` takes it. `others` are edits that the method does not show, `marks`
  // what the page alone knows of lights.
  get whole() {
    const { state } = this;
    const { scene, exposure, method, chosen, lights } = state;
    const [edits, all] = [state.edits(), state.edits(true)];
    const others = Object.fromEntries(Object.entries(all).filter(([key]) => !(key in edits)));
    const settings = chosen[method] ?? {};
    return { scene: scene.name, method, exposure, settings, edits, others, marks: marksOf(lights) };
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
