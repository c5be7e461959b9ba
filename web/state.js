// What the person has changed: plain data, one way to change it, listeners.

import { asWire, tidy } from "./lights.js";
import { isAlong, skySun, turned } from "./sun.js";

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);
const SWITCHES = ["enabled", "locked"]; // what a locked light still has

export class State {
  #listeners = [];

  constructor() {
    this.scene = null;
    this.lights = [];
    this.environment = null;
    this.materials = {};
    this.materialEdits = {};
    this.camera = null;
    this.exposure = 0;
    this.method = "direct_to_indirect";
    this.chosen = {}; // settings of methods, by name
    this.selection = []; // ids of lights, the one that was taken last at the end
    this.edited = ""; // what the hand was at last
    this.hand = null; // the material that is picked, and will be edited next
  }

  // Called as listener(what, moving): what is "scene", "lights", "environment", "materials",
  // "materialEdits", "restored" (of these), "hand", "camera", "exposure", "method", "settings" or
  // "selected";
  // moving is true while the hand is still at it.
  listen(listener) {
    this.#listeners.push(listener);
  }

  #tell(what, moving = false) {
    for (const listener of this.#listeners) listener(what, moving);
  }

  open(scene) {
    this.scene = scene;
    this.lights = structuredClone(scene.lights);
    this.environment = structuredClone(scene.environment.description);
    this.materials = {};
    this.materialEdits = {};
    this.hand = null;
    this.camera = structuredClone(scene.camera);
    this.selection = scene.lights.slice(0, 1).map(({ id }) => id);
    this.#tell("scene");
  }

  light(id) {
    return this.lights.find((light) => light.id === id);
  }

  isOwn(id) {
    return !this.scene.lights.some((light) => light.id === id);
  }

  get changed() {
    return !same(this.lights, this.scene?.lights);
  }

  get environmentChanged() {
    return !same(this.environment, this.scene?.environment.description);
  }

  get cameraMoved() {
    return !same(this.camera, this.scene?.camera);
  }

  // Replace some fields of a light.
  change(id, fields, moving = false) {
    this.changeAll({ [id]: fields }, moving);
  }

  // Fields of several by their ids; a locked one keeps all but its switches. A sun light that stands
  // where the sky has its sun is that sun: whichever of the two the hand moves takes the other along.
  changeAll(changes, moving = false) {
    this.edited = Object.keys(changes).join();
    for (const [id, asked] of Object.entries(changes)) {
      const old = this.light(id);
      if (!old) continue;
      const able = ([name]) => !old.locked || SWITCHES.includes(name);
      const fields = Object.fromEntries(Object.entries(asked).filter(able));
      const sun = old.type === "sun" && fields.direction ? skySun(this.environment) : null;
      const changed = tidy({ ...old, ...fields });
      this.lights = this.lights.map((light) => (light.id === id ? changed : light));
      if (sun && isAlong(old.direction, sun) && fields.direction[1] <= 0) {
        const direction = turned(fields.direction, -this.environment.rotation_degrees);
        const map = { ...this.environment.map, sun_direction: direction };
        this.environment = { ...this.environment, map };
      }
    }
    this.#tell("lights", moving);
  }

  // The whole environment; null is none.
  setEnvironment(environment, moving = false) {
    const [before, after] = [skySun(this.environment), skySun(environment)];
    this.environment = environment;
    if (before && after && !same(before, after)) {
      this.lights = this.lights.map((light) =>
        light.type === "sun" && !light.locked && isAlong(light.direction, before)
          ? { ...light, direction: after }
          : light,
      );
    }
    this.#tell("environment", moving);
  }

  resetEnvironment() {
    this.setEnvironment(structuredClone(this.scene.environment.description));
  }

  // Materials in the hand, whole ones by name, for a method that takes them.
  setMaterialEdits(materials, moving = false) {
    const names = Object.keys({ ...this.materialEdits, ...materials });
    this.edited = names.filter((name) => !same(this.materialEdits[name], materials[name])).join();
    this.materialEdits = materials;
    this.#tell("materialEdits", moving);
  }

  // A material is picked.
  hold(name) {
    if (name === this.hand) return;
    this.hand = this.edited = name;
    this.#tell("hand", true);
  }

  // Lights, environment and materials in the hand as they were.
  restore({ lights, environment, materialEdits }) {
    Object.assign(this, { lights, environment, materialEdits });
    this.selection = this.#alive(this.selection);
    this.#tell("restored");
  }

  // Edits of materials that the method has been precomputed with, by name.
  setMaterials(materials) {
    this.materials = materials;
    this.#tell("materials");
  }

  // The light that was taken last, whose grips are shown; null where none is selected.
  get selected() {
    return this.selection.at(-1) ?? null;
  }

  // A light alone; with `more` beside those that are selected, or no longer among them.
  select(id, more = false) {
    const others = this.selection.filter((other) => other !== id);
    const among = others.length < this.selection.length;
    if (!more) this.setSelection([id]);
    else this.setSelection(among ? others : [...others, id]);
  }

  // A light comes into the hand: with all that are selected if it is one of them.
  take(id) {
    const others = this.selection.filter((other) => other !== id);
    this.setSelection(others.length < this.selection.length ? [...others, id] : [id]);
  }

  setSelection(ids) {
    if (same(ids, this.selection)) return;
    this.selection = ids;
    this.#tell("selected");
  }

  // Of some lights those that there still are; where none is left, the first one.
  #alive(ids) {
    const left = ids.filter((id) => this.light(id));
    return left.length || !ids.length ? left : this.lights.slice(0, 1).map(({ id }) => id);
  }

  setExposure(stops, moving = false) {
    this.exposure = stops;
    this.#tell("exposure", moving);
  }

  // As the service describes it.
  get #method() {
    return this.scene?.methods.find(({ name }) => name === this.method);
  }

  // Which kinds of edit the method takes at once; see `methods` of the scene.
  takes(kind) {
    return this.#method?.edits.includes(kind);
  }

  // Types of material that it takes in edits.
  get models() {
    return this.#method?.models ?? [];
  }

  // Settings that a frame may ask it for, as they are chosen.
  get settings() {
    return { ...this.#method?.settings, ...this.chosen[this.method] };
  }

  setSettings(settings, moving = false) {
    const { method } = this;
    this.chosen = { ...this.chosen, [method]: { ...this.chosen[method], ...settings } };
    this.#tell("settings", moving);
  }

  setMethod(method) {
    if (method === this.method) return;
    this.method = method;
    this.#tell("method");
  }

  setCamera(camera, moving = false) {
    this.camera = camera;
    this.#tell("camera", moving);
  }

  // All of them at once, and which of them are selected.
  setLights(lights, selection = this.selection) {
    this.lights = lights;
    this.selection = this.#alive(selection);
    this.#tell("lights");
    this.#tell("selected");
  }

  // Added lights go; the scene's own can only be turned off. Locked ones stay as they are.
  remove(ids) {
    const asked = ({ id, locked }) => ids.includes(id) && !locked;
    const left = this.lights.filter((light) => !asked(light) || !this.isOwn(light.id));
    this.setLights(left.map((light) => (asked(light) ? { ...light, enabled: false } : light)));
  }

  // As the scene has them, all or some; locked ones stay as they are.
  reset(ids = this.lights.map(({ id }) => id)) {
    const own = new Map(structuredClone(this.scene.lights).map((light) => [light.id, light]));
    const asked = ({ id, locked }) => ids.includes(id) && !locked;
    const left = this.lights.filter((light) => !asked(light) || own.has(light.id));
    this.setLights(left.map((light) => (asked(light) ? own.get(light.id) : light)));
  }

  resetCamera() {
    this.setCamera(structuredClone(this.scene.camera));
  }

  // What differs from the scene's own, whose map may be a file that nobody can ask for by name.
  #environmentEdit() {
    const own = this.scene.environment.description;
    if (!this.environment) return { intensity: 0 };
    const changed = Object.entries(this.environment).filter(([key, value]) => !same(value, own?.[key]));
    return Object.fromEntries(changed);
  }

  // As `POST /api/scenes/{scene}/frame` and `relight render --edits` take them: what the method shows,
  // or everything.
  edits(everything = false) {
    const takes = (kind) => everything || this.takes(kind);
    const edits = {};
    const own = (light) => this.scene.lights.find(({ id }) => id === light.id);
    const lights = this.lights.map(asWire).filter((light) => !same(light, own(light)));
    if (lights.length && takes("lights")) edits.lights = lights;
    if (takes("materials")) {
      const { models } = this;
      const able = ([, { type }]) => everything || models.includes(type);
      const materials = Object.fromEntries(Object.entries(this.materialEdits).filter(able));
      if (Object.keys(materials).length) edits.materials = materials;
    } else if (Object.keys(this.materials).length && this.takes("camera")) {
      // A method that holds the camera fixed too has not been precomputed with them.
      edits.materials = this.materials;
    }
    if (this.environmentChanged && takes("environment")) edits.environment = this.#environmentEdit();
    if (this.cameraMoved) {
      const { position, target, up, fov_y_degrees } = this.camera;
      edits.camera = { position, target, up, fov_y_degrees };
    }
    return edits;
  }

  // The same, the material that is picked named last: the service takes it in hand before it changes.
  asked() {
    const edits = this.edits();
    if (!this.hand || !this.takes("materials")) return edits;
    const { [this.hand]: change = {}, ...others } = edits.materials ?? {};
    return { ...edits, materials: { ...others, [this.hand]: change } };
  }
}
