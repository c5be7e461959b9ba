// The environment's side: which map, how it is turned, how bright, and where the sun of a sky stands.

import { fromHex, strength, toHex, withStrength } from "./colour.js";
import { capital, element, field, number } from "./fields.js";
import { sunAngles, sunDirection } from "./sun.js";

const DECADES = 2; // of the brightness slider, to either side of 1
const [NONE, EVEN, SKY] = ["none", "even", "sky"];
const AFTERNOON = { height: 40, azimuth: 60 };

export class EnvironmentPanel {
  #built = null;
  #fields = [];

  constructor(state, { box, map, reset }) {
    Object.assign(this, { state, box, map, resetButton: reset });
    map.addEventListener("change", () => this.#choose(map.value));
    reset.addEventListener("click", () => state.resetEnvironment());
  }

  open() {
    const { description, maps } = this.state.scene.environment;
    const own = typeof description?.map === "string" ? description.map : null;
    const names = [...new Set([own, ...maps].filter(Boolean))];
    this.map.replaceChildren(
      new Option("None", NONE),
      ...names.map((name) => new Option(capital(name), `map ${name}`)),
      new Option("Even", EVEN),
      new Option("Sky", SKY),
    );
    this.#built = null;
    this.draw();
  }

  draw() {
    const { environment } = this.state;
    const kind = kindOf(environment);
    this.resetButton.disabled = !this.state.environmentChanged;
    this.map.value = kind;
    // Inputs are kept while the kind of map stays, so that focus and drags survive.
    if (kind !== this.#built) this.#build(environment);
    this.#built = kind;
    if (environment) for (const show of this.#fields) show(environment);
  }

  #choose(kind) {
    const old = this.state.environment ?? { rotation_degrees: 0, intensity: 1 };
    const maps = { [EVEN]: [0.5, 0.5, 0.5], [SKY]: this.#sky() };
    const map = maps[kind] ?? kind.replace(/^map /, "");
    this.state.setEnvironment(kind === NONE ? null : { ...old, map });
  }

  // A clear sky as the schema has it; about as bright as a lit room.
  #sky() {
    const { properties } = this.state.scene.environment.sky;
    const fields = Object.entries(properties).map(([name, schema]) => [name, schema.default]);
    return { ...Object.fromEntries(fields), sun_direction: sunDirection(AFTERNOON) };
  }

  #build(environment) {
    this.#fields = [];
    this.box.replaceChildren();
    if (!environment) return;
    if (Array.isArray(environment.map)) {
      this.#colour("Even radiance");
    } else if (typeof environment.map === "object") {
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

  // A slider for the hand and a number for what is exact; the number of a slider in decades may
  // lie beyond its ends.
  #slider(label, range, unit, { get, set, toSlider = (x) => x, fromSlider = (x) => x }) {
    const slider = element("input", { type: "range", ...range });
    const exact = element("input", { type: "number", step: "any", className: "exact" });
    exact.setAttribute("aria-label", `${label}, exact`);
    const change = (value, moving) => this.#change(set(value, this.state.environment), moving);
    slider.addEventListener("input", () => change(fromSlider(slider.valueAsNumber), true));
    slider.addEventListener("change", () => change(fromSlider(slider.valueAsNumber), false));
    exact.min = unit === "×" ? 0 : range.min;
    if (unit !== "×") exact.max = range.max;
    exact.addEventListener("change", () => {
      if (exact.validity.valid && !Number.isNaN(exact.valueAsNumber)) {
        change(exact.valueAsNumber, false);
      }
    });
    const both = element("span", { className: "pair" });
    both.append(slider, exact);
    this.box.append(field(label, both, unit || " "));
    this.#fields.push((environment) => {
      const value = get(environment);
      if (document.activeElement !== slider) slider.value = toSlider(value);
      slider.setAttribute("aria-valuetext", `${number(value)} ${unit}`);
      if (document.activeElement !== exact) exact.value = number(value);
    });
  }

  #colour(label) {
    const input = element("input", { type: "color" });
    const pick = (moving) => {
      const { map } = this.state.environment;
      this.#change({ map: fromHex(input.value, strength(map) || 0.5) }, moving);
    };
    input.addEventListener("input", () => pick(true));
    input.addEventListener("change", () => pick(false));
    this.box.append(field(label, input));
    this.#fields.push(({ map }) => {
      if (document.activeElement !== input) input.value = toHex(map);
    });
  }
}

function kindOf(environment) {
  if (!environment) return NONE;
  if (typeof environment.map === "string") return `map ${environment.map}`;
  return Array.isArray(environment.map) ? EVEN : SKY;
}

const wrapped = (angle) => ((((angle + 180) % 360) + 360) % 360) - 180;
