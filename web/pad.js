// The whole sphere as a small map, as it stands round the scene: drag it to turn the environment,
// drag the marks on it to move the sun and the area light.

import { toHex } from "./colour.js";
import { element } from "./fields.js";
import { sunAngles, sunDirection, turned } from "./sun.js";
import { sub } from "./vector.js";

const RADIANS = Math.PI / 180;
const RIM = 64; // points of an area light's outline
const KEPT = 24; // pictures of maps
const HIGHEST = 89.5; // degrees: of what stands overhead no azimuth is left
const STEPS = {
  ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1],
};

// What can be moved: its name, where its light travels, and the environment with it elsewhere.
const MARKS = {
  sun: {
    label: "Sun",
    lowest: 0,
    get: ({ map }) => map?.sun_direction,
    set: (environment, direction) => ({
      ...environment, map: { ...environment.map, sun_direction: direction },
    }),
  },
  lamp: {
    label: "Area light",
    lowest: -HIGHEST,
    get: ({ area_light: light }) => light?.direction,
    set: (environment, direction) => ({
      ...environment, area_light: { ...environment.area_light, direction },
    }),
  },
};

export class Pad {
  #pictures = new Map();
  #asking = false;
  #shown = null;
  #marks = new Map();
  #drag = null;

  // picture(map) resolves to an ImageBitmap of a map that is not turned.
  constructor(state, box, picture) {
    Object.assign(this, { state, box, picture });
    this.canvas = element("canvas", { width: 512, height: 256 });
    this.canvas.setAttribute("aria-hidden", "true");
    box.append(this.canvas);
    for (const name of Object.keys(MARKS)) {
      const node = element("button", { type: "button", className: `mark ${name}`, hidden: true });
      node.addEventListener("keydown", (event) => this.#key(event, name));
      this.#marks.set(name, node);
      box.append(node);
    }
    box.addEventListener("pointerdown", (event) => this.#down(event));
    box.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) {
      box.addEventListener(end, (event) => this.#up(event));
    }
  }

  // Another scene: its own map may be another one of the same name.
  open() {
    this.#pictures.clear();
    this.#shown = null;
  }

  draw() {
    const { environment } = this.state;
    this.box.hidden = !environment;
    if (!environment) return;
    for (const [name, node] of this.#marks) this.#place(name, node, environment);
    this.#paint();
    this.#ask();
  }

  // The picture of the newest map, one request at a time; the last one stays until it is there.
  async #ask() {
    const { map } = this.state.environment ?? {};
    const key = JSON.stringify(map);
    if (map === undefined || this.#pictures.has(key)) {
      if (map !== undefined && this.#shown !== key) {
        this.#shown = key;
        this.#paint();
      }
      return;
    }
    if (this.#asking) return;
    this.#asking = true;
    const scene = this.state.scene;
    let image = null;
    try {
      image = await this.picture(map);
    } catch {
      // The frame says what is wrong with the map.
    } finally {
      this.#asking = false;
    }
    if (scene === this.state.scene) {
      this.#pictures.set(key, image);
      if (this.#pictures.size > KEPT) this.#pictures.delete(this.#pictures.keys().next().value);
    }
    this.#ask();
  }

  #paint() {
    const { environment, camera } = this.state;
    const { width, height } = this.canvas;
    const context = this.canvas.getContext("2d");
    context.clearRect(0, 0, width, height);
    const image = this.#pictures.get(this.#shown);
    const shift = -(environment.rotation_degrees / 360) * width;
    const first = ((shift % width) + width) % width;
    if (image) for (const x of [first - width, first]) context.drawImage(image, x, 0, width, height);
    // The horizon, and what the camera looks at.
    context.fillStyle = "rgb(255 255 255 / .25)";
    context.fillRect(0, height / 2 - 0.5, width, 1);
    const ahead = place(sub(camera.position, camera.target));
    frame(context, ahead.u * width, ahead.v * height);
    if (environment.area_light) this.#outline(context, environment);
  }

  // The rim of the area light; lines over the seam of the map are left out.
  #outline(context, { area_light: light, rotation_degrees: rotation }) {
    const { width, height } = this.canvas;
    const rim = ring(turned(light.direction, rotation), light.radius_degrees).map(place);
    for (const [colour, line] of [["rgb(0 0 0 / .6)", 4], ["#fff", 2]]) {
      context.strokeStyle = colour;
      context.lineWidth = line;
      context.beginPath();
      rim.forEach(({ u, v }, i) => {
        const far = i === 0 || Math.abs(u - rim[i - 1].u) > 0.5;
        context[far ? "moveTo" : "lineTo"](u * width, v * height);
      });
      context.stroke();
    }
  }

  #place(name, node, environment) {
    const { label, get } = MARKS[name];
    const direction = get(environment);
    node.hidden = !direction;
    if (!direction) return;
    const world = turned(direction, environment.rotation_degrees);
    const { u, v } = place(world);
    node.style.left = `${100 * u}%`;
    node.style.top = `${100 * v}%`;
    if (name === "lamp") node.style.background = toHex(environment.area_light.radiance);
    const { height, azimuth } = sunAngles(world);
    const at = `azimuth ${azimuth.toFixed(0)}°, height ${height.toFixed(0)}°`;
    node.title = `${label}: ${at}`;
    node.setAttribute("aria-label", `${label}, ${at}. Arrow keys move it.`);
  }

  #at(event) {
    const box = this.box.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  #down(event) {
    if (event.button !== 0 || !this.state.environment) return;
    event.preventDefault();
    const mark = event.target.closest(".mark");
    const name = [...this.#marks].find(([, node]) => node === mark)?.[0] ?? null;
    this.box.setPointerCapture(event.pointerId);
    mark?.focus({ preventScroll: true });
    this.#drag = { pointer: event.pointerId, name, last: this.#at(event), moved: false };
  }

  #move(event) {
    const drag = this.#drag;
    if (drag?.pointer !== event.pointerId) return;
    const [x, y] = this.#at(event);
    const across = x - drag.last[0];
    if (!across && y === drag.last[1]) return;
    Object.assign(drag, { last: [x, y], moved: true });
    if (drag.name) this.#put(drag.name, { azimuth: 360 * (x - 0.5), height: 180 * (0.5 - y) }, true);
    else this.#turn(-360 * across, true);
  }

  #up(event) {
    const drag = this.#drag;
    if (drag?.pointer !== event.pointerId) return;
    this.#drag = null;
    if (drag.moved) this.state.setEnvironment({ ...this.state.environment }, false);
  }

  #turn(degrees, moving) {
    const { environment } = this.state;
    const rotation = (environment.rotation_degrees + degrees) % 360;
    this.state.setEnvironment({ ...environment, rotation_degrees: rotation }, moving);
  }

  #put(name, { azimuth, height }, moving) {
    const { environment } = this.state;
    const { lowest, set } = MARKS[name];
    const limited = Math.max(lowest, Math.min(HIGHEST, height));
    const world = sunDirection({ azimuth, height: limited });
    const direction = turned(world, -environment.rotation_degrees);
    this.state.setEnvironment(set(environment, direction), moving);
  }

  #key(event, name) {
    const step = STEPS[event.key];
    if (!step || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    const { environment } = this.state;
    const size = event.altKey ? 0.2 : event.shiftKey ? 10 : 2;
    const world = turned(MARKS[name].get(environment), environment.rotation_degrees);
    const { azimuth, height } = sunAngles(world);
    this.#put(name, { azimuth: azimuth + size * step[0], height: height + size * step[1] }, false);
  }
}

// Where on the map stands what light travels along a direction from, 0 to 1 each.
function place(direction) {
  const { height, azimuth } = sunAngles(direction);
  return { u: 0.5 + azimuth / 360, v: 0.5 - height / 180 };
}

// Directions at an angle from another one, all round it.
function ring(direction, degrees) {
  const { height, azimuth } = sunAngles(direction);
  const [c, s] = [Math.cos(degrees * RADIANS), Math.sin(degrees * RADIANS)];
  const [ch, sh] = [Math.cos(height * RADIANS), Math.sin(height * RADIANS)];
  return Array.from({ length: RIM + 1 }, (_, i) => {
    const [up, aside] = [Math.cos, Math.sin].map((f) => s * f((2 * Math.PI * i) / RIM));
    // Turned from straight ahead up to the height, then round to the azimuth.
    const [flat, y] = [c * ch - up * sh, c * sh + up * ch];
    const around = azimuth * RADIANS;
    const x = flat * Math.sin(around) + aside * Math.cos(around);
    const z = -flat * Math.cos(around) + aside * Math.sin(around);
    return [-x, -y, -z];
  });
}

function frame(context, x, y) {
  const { width } = context.canvas;
  for (const [colour, line] of [["rgb(0 0 0 / .5)", 4], ["rgb(255 255 255 / .9)", 1.5]]) {
    context.strokeStyle = colour;
    context.lineWidth = line;
    for (const at of [x - width, x, x + width]) {
      context.beginPath();
      for (const [i, j] of [[-1, -1], [1, -1], [1, 1], [-1, 1]]) {
        context.moveTo(at + 22 * i, y + 9 * j);
        context.lineTo(at + 22 * i, y + 15 * j);
        context.lineTo(at + 14 * i, y + 15 * j);
      }
      context.stroke();
    }
  }
}
