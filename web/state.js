// What the person has changed: plain data, one way to change it, listeners.

import { strength } from "./colour.js";
import { isAlong, skySun, turned } from "./sun.js";
import { add, mix, scale, sub } from "./vector.js";

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

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
    this.selected = null;
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
    this.selected = scene.lights[0]?.id ?? null;
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

  // Replace some fields of a light. A sun light that stands where the sky has its sun is that sun:
  // whichever of the two the hand moves takes the other along.
  change(id, fields, moving = false) {
    this.edited = id;
    const old = this.light(id);
    const sun = old?.type === "sun" && fields.direction ? skySun(this.environment) : null;
    this.lights = this.lights.map((light) => (light.id === id ? { ...light, ...fields } : light));
    if (sun && isAlong(old.direction, sun) && fields.direction[1] <= 0) {
      const direction = turned(fields.direction, -this.environment.rotation_degrees);
      const map = { ...this.environment.map, sun_direction: direction };
      this.environment = { ...this.environment, map };
    }
    this.#tell("lights", moving);
  }

  // The whole environment; null is none.
  setEnvironment(environment, moving = false) {
    const [before, after] = [skySun(this.environment), skySun(environment)];
    this.environment = environment;
    if (before && after && !same(before, after)) {
      this.lights = this.lights.map((light) =>
        light.type === "sun" && isAlong(light.direction, before)
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
    if (!this.light(this.selected)) this.selected = this.lights[0]?.id ?? null;
    this.#tell("restored");
  }

  // Edits of materials that the method has been precomputed with, by name.
  setMaterials(materials) {
    this.materials = materials;
    this.#tell("materials");
  }

  select(id) {
    if (id === this.selected) return;
    this.selected = id;
    this.#tell("selected");
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

  // A new light of a type, in view, as strong as its like in the scene.
  addLight(type) {
    let number = 1;
    while (this.light(`${type}-${number}`)) number += 1;
    const id = `${type}-${number}`;
    const { position, target } = this.camera;
    const place = add(mix(position, target, 0.9), scale(this.camera.up, 0.08 * this.scene.diagonal));
    const properties = this.scene.light_types[type].properties;
    const light = { id, type, enabled: true, intensity: this.#usualIntensity(type) };
    if (properties.position) light.position = place;
    if (properties.target) light.target = add(place, [0, -0.2 * this.scene.diagonal, 1e-3]);
    if (properties.direction) light.direction = sub(target, add(position, scale(this.camera.up, 1)));
    const sizes = { width: 0.08, height: 0.08, radius: 0.05, reference_distance: 0.2 };
    for (const [name, share] of Object.entries(sizes)) {
      // A beam's width and height are those at one metre, whatever the scene.
      if (properties[name] && (type !== "uberlight" || name === "reference_distance")) {
        light[name] = share * this.scene.diagonal;
      }
    }
    for (const [name, schema] of Object.entries(properties)) {
      if (!(name in light) && schema.default !== undefined) light[name] = schema.default;
    }
    this.setLights([...this.lights, light], id);
  }

  // All of them at once, and which of them is selected.
  setLights(lights, selected = this.selected) {
    this.lights = lights;
    this.selected = this.light(selected) ? selected : (lights[0]?.id ?? null);
    this.#tell("lights");
    this.#tell("selected");
  }

  #usualIntensity(type) {
    const like = this.scene.lights.filter((light) => light.type === type);
    if (like.length && type !== "uberlight") return like[0].intensity;
    const points = this.scene.lights.map((light) => strength(light.intensity) * this.#reach(light));
    const d = this.scene.diagonal;
    const sizes = { width: 0.08 * d, height: 0.08 * d, radius: 0.05 * d };
    const wanted = { type, ...sizes, reference_distance: 0.2 * d };
    const s = (points.length ? Math.max(...points) || 1 : 0.1 * d * d) / this.#reach(wanted);
    return [s, s, s];
  }

  // What a light of strength 1 gives straight ahead is what a point of so many W/sr gives: a lamp
  // of A square metres is a point of A times its radiance.
  #reach({ type, width, height, radius, reference_distance: distance }) {
    switch (type) {
      case "area": return width * height;
      case "disk": case "sphere": return Math.PI * radius ** 2;
      case "distant": case "sun": return 0.2 * this.scene.diagonal ** 2;
      case "uberlight": return distance ** 2;
      default: return 1;
    }
  }

  // Added lights go; the scene's own can only be turned off.
  removeLight(id) {
    this.setLights(this.lights.filter((light) => light.id !== id));
  }

  reset(id = null) {
    const original = structuredClone(this.scene.lights);
    const one = (light) => (light.id === id ? original.find((l) => l.id === id) : light);
    this.setLights(id ? this.lights.map(one) : original);
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

  // As `POST /api/scenes/{scene}/frame` and `relight render --edits` take them.
  edits() {
    const edits = {};
    const lights = this.lights.filter(
      (light) => !same(light, this.scene.lights.find((old) => old.id === light.id)),
    );
    if (lights.length && this.takes("lights")) edits.lights = lights;
    if (this.takes("materials")) {
      const { models } = this;
      const able = ([, { type }]) => models.includes(type);
      const materials = Object.fromEntries(Object.entries(this.materialEdits).filter(able));
      if (Object.keys(materials).length) edits.materials = materials;
    } else if (Object.keys(this.materials).length && this.takes("camera")) {
      // A method that holds the camera fixed too has not been precomputed with them.
      edits.materials = this.materials;
    }
    if (this.environmentChanged && this.takes("environment")) edits.environment = this.#environmentEdit();
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
