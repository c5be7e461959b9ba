// The environment's side: which map, how it is turned, how bright, where the sun of a sky stands, an
// area light before it, and whether the camera sees any of it.

import { strength, withStrength } from "./colour.js";
import { capital, colour, element, field, group, slider } from "./fields.js";
import { Pad } from "./pad.js";
import { environmentOf, SKIES } from "./sky_presets.js";
import { sunAngles, sunDirection } from "./sun.js";

const DECADES = 2; // of the brightness slider, to either side of 1
const [NONE, BLACK, EVEN, SKY] = ["none", "black", "even", "sky"];
const OPEN = { least: 0, most: "" }; // what a slider in decades takes beyond its ends
const OUTDOORS = 0.1; // a sky's brightness at first: its own is that of a day, for another exposure
const AFTERNOON = { height: 40, azimuth: 60 };
const LAMP = { direction: sunDirection({ height: 40, azimuth: -60 }), radius_degrees: 10 };

export class EnvironmentPanel {
  #built = null;
  #fields = [];

  // picture(map) resolves to a small picture of a map, send(file) to what the service calls it.
  constructor(state, { box, pad, map, file, open, reset }, { picture, send }) {
    Object.assign(this, { state, box, map, resetButton: reset });
    this.pad = new Pad(state, pad, picture);
    map.addEventListener("change", () => this.#choose(map.value));
    reset.addEventListener("click", () => state.resetEnvironment());
    open.addEventListener("click", () => file.click());
    file.addEventListener("change", async () => {
      const [chosen] = file.files;
      if (!chosen) return;
      const { textContent: usual } = open;
      Object.assign(open, { disabled: true, textContent: "Reading …" });
      try {
        const sent = await send(chosen);
        const { uploads } = state.scene.environment;
        if (!uploads.some(({ name }) => name === sent.name)) uploads.unshift(sent);
        this.#list();
        this.#choose(`map ${sent.name}`);
      } catch {
        // Why is told beside the picture.
      } finally {
        Object.assign(open, { disabled: false, textContent: usual });
        file.value = "";
      }
    });
  }

  open() {
    this.#list();
    this.pad.open();
    this.#built = null;
    this.draw();
  }

  #list() {
    const { description, maps, uploads } = this.state.scene.environment;
    const own = typeof description?.map === "string" ? description.map : null;
    const names = [...new Set([own, ...maps].filter(Boolean))];
    this.map.replaceChildren(
      new Option("None", NONE),
      ...names.map((name) => new Option(capital(name), `map ${name}`)),
      new Option("Sky", SKY),
      new Option("Even", EVEN),
      new Option("Black", BLACK),
      group("Presets", Object.entries(SKIES).map(([name, { label }]) => new Option(label, `preset ${name}`))),
    );
    if (!uploads.length) return;
    const opened = uploads.map(({ name, label }) => new Option(label, `map ${name}`));
    this.map.append(group("Opened", opened));
  }

  draw() {
    const { environment } = this.state;
    const kind = kindOf(environment);
    const built = `${kind} ${Boolean(environment?.area_light)}`;
    this.resetButton.disabled = !this.state.environmentChanged;
    this.map.value = kind;
    this.map.title = this.map.selectedOptions[0]?.text ?? "";
    this.pad.draw();
    // Inputs are kept while the kind of map stays, so that focus and drags survive.
    if (built !== this.#built) this.#build(environment);
    this.#built = built;
    if (environment) for (const show of this.#fields) show(environment);
  }

  #choose(kind) {
    const usual = { rotation_degrees: 0, intensity: 1, area_light: null, background: true };
    const old = this.state.environment ?? usual;
    const preset = kind.match(/^preset (.*)/)?.[1];
    if (preset) {
      this.state.setEnvironment(environmentOf(preset, { sky: this.#sky(), environment: old }));
      return;
    }
    const maps = { [BLACK]: [0, 0, 0], [EVEN]: [0.5, 0.5, 0.5], [SKY]: this.#sky() };
    const map = maps[kind] ?? kind.replace(/^map /, "");
    // How bright a map is says nothing of the next one.
    const own = this.state.scene.environment.description;
    const usualOf = JSON.stringify(own?.map) === JSON.stringify(map) ? own.intensity : 1;
    const next = { ...old, map, intensity: kind === SKY ? OUTDOORS : usualOf };
    // Nothing else shines then.
    if (kind === BLACK) next.area_light ??= this.#lamp();
    this.state.setEnvironment(kind === NONE ? null : next);
  }

  // An area light as the schema has it.
  #lamp() {
    const { radiance } = this.state.scene.environment.area_light.properties;
    return { radiance: radiance.default, ...LAMP };
  }

  // A clear sky as the schema has it.
  #sky() {
    const { properties } = this.state.scene.environment.sky;
    const fields = Object.entries(properties).map(([name, schema]) => [name, schema.default]);
    return { ...Object.fromEntries(fields), sun_direction: sunDirection(AFTERNOON) };
  }

  #build(environment) {
    this.#fields = [];
    this.box.replaceChildren();
    if (!environment) return;
    if (kindOf(environment) === EVEN) {
      this.#colour("Even radiance", {
        get: ({ map }) => map,
        set: (map) => ({ map }),
      });
    } else if (kindOf(environment) === SKY) {
      this.#sun("Sun height", "height", 0, 90);
      this.#sun("Sun azimuth", "azimuth", -180, 180);
      const { minimum, maximum } = this.state.scene.environment.sky.properties.turbidity;
      this.#slider("Turbidity", { min: minimum, max: maximum, step: 0.1 }, "", {
        get: ({ map }) => map.turbidity,
        set: (turbidity, { map }) => ({ map: { ...map, turbidity } }),
      });
      this.#slider("Ground", { min: 0, max: 1, step: 0.01 }, "", {
        get: ({ map }) => strength(map.ground),
        set: (albedo, { map }) => ({ map: { ...map, ground: withStrength(map.ground, albedo) } }),
      });
    }
    if (!Array.isArray(environment.map)) {
      this.#slider("Rotation", { min: -180, max: 180, step: 1 }, "°", {
        get: ({ rotation_degrees: angle }) => wrapped(angle),
        set: (angle) => ({ rotation_degrees: angle }),
      });
    }
    this.#slider("Brightness", { min: -DECADES, max: DECADES, step: 0.01 }, "×", {
      get: ({ intensity }) => intensity,
      set: (intensity) => ({ intensity }),
      toSlider: (intensity) => Math.log10(Math.max(intensity, 1e-12)),
      fromSlider: (value) => 10 ** value,
      ...OPEN,
    });
    this.#switch("Background", "whether the camera sees the environment", {
      get: ({ background }) => background,
      set: (background) => ({ background }),
    });
    this.#switch("Area light", "a round lamp on the sphere, added to the map", {
      get: ({ area_light: light }) => Boolean(light),
      set: (on) => ({ area_light: on ? this.#lamp() : null }),
    });
    if (environment.area_light) this.#areaLight();
  }

  #areaLight() {
    const lamp = (fields) => ({ area_light: { ...this.state.environment.area_light, ...fields } });
    this.#colour("Light colour", {
      get: ({ area_light: light }) => light.radiance,
      set: (radiance) => lamp({ radiance }),
    });
    const { minimum, maximum } = this.state.scene.environment.area_light.properties.radius_degrees;
    this.#slider("Light radius", { min: minimum, max: maximum, step: 0.25 }, "°", {
      get: ({ area_light: light }) => light.radius_degrees,
      set: (radius) => lamp({ radius_degrees: radius }),
    });
    this.#slider("Radiance", { min: -1, max: 4, step: 0.01 }, " ", {
      get: ({ area_light: light }) => strength(light.radiance),
      set: (radiance, { area_light: light }) =>
        lamp({ radiance: withStrength(light.radiance, radiance) }),
      toSlider: (radiance) => Math.log10(Math.max(radiance, 1e-12)),
      fromSlider: (value) => 10 ** value,
      ...OPEN,
    });
  }

  #change(fields, moving) {
    this.state.setEnvironment({ ...this.state.environment, ...fields }, moving);
  }

  #sun(label, name, min, max) {
    this.#slider(label, { min, max, step: 0.5 }, "°", {
      get: ({ map }) => sunAngles(map.sun_direction)[name],
      set: (angle, { map }) => {
        const angles = { ...sunAngles(map.sun_direction), [name]: angle };
        // Of a sun that stands overhead no azimuth is left.
        angles.height = Math.min(angles.height, 89.5);
        return { map: { ...map, sun_direction: sunDirection(angles) } };
      },
    });
  }

  #add({ row, show }) {
    this.box.append(row);
    this.#fields.push(show);
  }

  #slider(label, range, unit, { set, ...how }) {
    const change = (value, moving) => this.#change(set(value, this.state.environment), moving);
    this.#add(slider(label, range, unit, { ...how, change }));
  }

  #switch(label, title, { get, set }) {
    const input = element("input", { type: "checkbox", title });
    input.addEventListener("change", () => this.#change(set(input.checked), false));
    this.box.append(field(label, input));
    this.#fields.push((environment) => {
      input.checked = get(environment);
    });
  }

  #colour(label, { get, set }) {
    this.#add(colour(label, { get, change: (value, moving) => this.#change(set(value), moving) }));
  }
}

function kindOf(environment) {
  if (!environment) return NONE;
  if (typeof environment.map === "string") return `map ${environment.map}`;
  if (!Array.isArray(environment.map)) return SKY;
  return strength(environment.map) > 0 ? EVEN : BLACK;
}

const wrapped = (angle) => ((((angle + 180) % 360) + 360) % 360) - 180;
