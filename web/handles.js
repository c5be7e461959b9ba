// Handles over the picture, where the lights are: drag across, wheel or Shift-drag for depth, keys.

import { heightAt, onBall, project, unproject } from "./camera.js";
import { toHex } from "./colour.js";
import { outline } from "./outline.js";
import { add, length, normalize, scale, sub } from "./vector.js";

const SVG = "http://www.w3.org/2000/svg";
const MARKS = {
  point: "M12 2v-3M12 25v-3M2 12h-3M25 12h-3M5 5 3 3M19 19l2 2M5 19l-2 2M19 5l2-2",
  spot: "M4 16 1 24M20 16l3 8",
  area: "M1 1h22v22H1z",
  disk: "M12 1a11 11 0 0 1 0 22a11 11 0 0 1 0-22",
  sphere: "M12 1a11 11 0 0 1 0 22a11 11 0 0 1 0-22M1 12c6 4 16 4 22 0",
  projector: "M4 16 1 24h22l-3-8M9 24v-6M15 24v-6",
  uberlight: "M4 16 1 24M20 16l3 8M1 24c7 3 15 3 22 0",
  distant: "M4 24v5M12 25v6M20 24v5",
  sun: "M4 24v5M12 25v6M20 24v5M12 2v-4",
};
const MARGIN = 0.035; // of the picture, for lights outside it

// The points of a light that can be dragged: name, place, and what to change for a new place.
export function gripsOf(light, scene, camera) {
  const grips = [];
  if (light.position) {
    grips.push({ name: "position", at: light.position, move: (p) => ({ position: p }) });
  } else if (light.direction) {
    // A light at infinity is held by a point on its way to the middle of the picture, on a ball.
    const centre = camera.target;
    const radius = 0.3 * scene.diagonal;
    const at = sub(centre, scale(normalize(light.direction), radius));
    const near = project(camera, at).depth < project(camera, centre).depth;
    const move = (p) => ({ direction: sub(centre, p) });
    grips.push({ name: "direction", at, move, ball: { centre, radius, near } });
  }
  if (light.target) {
    grips.push({ name: "target", at: light.target, move: (p) => ({ target: p }) });
  }
  return grips;
}

export class Handles {
  #nodes = new Map();
  #drag = null;

  constructor(state, { picture, handles, lines }) {
    this.state = state;
    this.picture = picture;
    this.box = handles;
    this.lines = lines;
    this.lines.setAttribute("viewBox", "0 0 1 1");
    this.lines.setAttribute("preserveAspectRatio", "none");
  }

  // Put every handle and line where it belongs; keep the nodes, so that focus stays.
  draw() {
    const { state } = this;
    const wanted = new Set();
    const paths = [];
    for (const light of state.takes("lights") ? state.lights : []) {
      const grips = gripsOf(light, state.scene, state.camera);
      const selected = light.id === state.selected;
      for (const grip of grips) {
        if (grip.name === "target" && !selected) continue;
        const key = `${light.id} ${grip.name}`;
        wanted.add(key);
        if (!this.#nodes.has(key)) this.#nodes.set(key, this.#make(light.id, grip.name));
        this.#place(this.#nodes.get(key), light, grip, selected);
      }
      if (selected) paths.push(...outline(light, state.camera));
    }
    for (const [key, node] of this.#nodes) {
      if (wanted.has(key)) continue;
      node.remove();
      this.#nodes.delete(key);
    }
    // A dark line under each, rather than a shadow: filters are slow without a GPU.
    this.lines.replaceChildren(
      ...paths.flatMap(({ d, quiet }) => [path(d, "under"), path(d, quiet ? "quiet" : "")]),
    );
    for (const line of this.lines.children) line.setAttribute("vector-effect", "non-scaling-stroke");
  }

  focus(id) {
    this.#nodes.get(`${id} position`)?.focus();
  }

  #make(id, name) {
    const node = document.createElement("button");
    node.type = "button";
    node.className = `handle ${name === "target" ? "target" : "source"}`;
    node.dataset.light = id;
    node.dataset.grip = name;
    const svg = document.createElementNS(SVG, "svg");
    svg.setAttribute("viewBox", "-3 -3 30 30");
    svg.setAttribute("aria-hidden", "true");
    node.append(svg);
    node.addEventListener("pointerdown", (event) => this.#down(event, id, name));
    node.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) {
      node.addEventListener(end, (event) => this.#up(event));
    }
    node.addEventListener("wheel", (event) => this.#wheel(event, id, name), { passive: false });
    node.addEventListener("keydown", (event) => this.#key(event, id, name));
    node.addEventListener("focus", () => this.state.select(id));
    this.box.append(node);
    return node;
  }

  #place(node, light, grip, selected) {
    const { x, y, depth } = project(this.state.camera, grip.at);
    const behind = depth <= 0;
    const inside = !behind && x >= 0 && x <= 1 && y >= 0 && y <= 1;
    let [px, py] = [x, y];
    let angle = 0;
    if (!inside) {
      // On the border, in the direction where the light is; behind the eye it is mirrored.
      const sign = behind ? -1 : 1;
      const [dx, dy] = [sign * (x - 0.5) || 1e-9, sign * (y - 0.5)];
      const reach = (0.5 - MARGIN) / Math.max(Math.abs(dx), Math.abs(dy));
      [px, py] = [0.5 + dx * reach, 0.5 + dy * reach];
      angle = (Math.atan2(dy, dx) * 180) / Math.PI;
    }
    node.style.left = `${100 * px}%`;
    node.style.top = `${100 * py}%`;
    node.classList.toggle("selected", selected);
    node.classList.toggle("off", !light.enabled);
    node.dataset.outside = String(!inside);
    const drawn = `${inside}${light.type}${light.enabled}${toHex(light.intensity)}${Math.round(angle)}`;
    if (node.dataset.drawn !== drawn) {
      node.dataset.drawn = drawn;
      node.firstChild.replaceChildren(...glyph(light, grip.name, inside, angle));
    }
    const place = grip.at.map((v) => v.toFixed(2)).join(", ");
    const off = light.enabled ? "" : ", off";
    const outside = inside ? "" : ", outside the picture";
    node.title = `${light.id}${grip.name === "target" ? " aims here" : ""}${outside}`;
    node.setAttribute(
      "aria-label",
      `Light ${light.id}${off}, ${grip.name} ${place}${outside}. Arrow keys move it, page keys change its depth.`,
    );
  }

  #grip(id, name) {
    const light = this.state.light(id);
    return gripsOf(light, this.state.scene, this.state.camera).find((grip) => grip.name === name);
  }

  #depth(at) {
    const { camera, scene } = this.state;
    const { depth } = project(camera, at);
    // A light behind the eye comes in front of it, as far as what the camera looks at.
    return depth > 1e-3 * scene.diagonal ? depth : length(sub(camera.target, camera.position));
  }

  #at(event) {
    const box = this.picture.getBoundingClientRect();
    return [(event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height];
  }

  #down(event, id, name) {
    if (event.button !== 0) return;
    event.preventDefault();
    event.stopPropagation();
    const node = event.currentTarget;
    node.setPointerCapture(event.pointerId);
    node.focus({ preventScroll: true });
    this.state.select(id);
    const { at, ball } = this.#grip(id, name);
    const depth = this.#depth(at);
    const [x, y] = this.#at(event);
    const shown = project(this.state.camera, at);
    // Held where it was touched, unless it comes in from outside.
    const hold = node.dataset.outside === "true" ? [0, 0] : [shown.x - x, shown.y - y];
    this.#drag = {
      id, name, depth, ball, hold, pointer: event.pointerId, last: [x, y], moved: false,
    };
  }

  #move(event) {
    const drag = this.#drag;
    if (!drag || drag.pointer !== event.pointerId) return;
    const [x, y] = this.#at(event);
    if (x === drag.last[0] && y === drag.last[1]) return;
    if (event.shiftKey) {
      drag.ball = null;
      drag.depth *= Math.exp(2 * (drag.last[1] - y));
      // The place on the picture stays while the depth changes.
      drag.hold = [drag.hold[0] + drag.last[0] - x, drag.hold[1] + drag.last[1] - y];
    }
    drag.last = [x, y];
    drag.moved = true;
    this.#put(drag, x + drag.hold[0], y + drag.hold[1], true);
  }

  #up(event) {
    const drag = this.#drag;
    if (!drag || drag.pointer !== event.pointerId) return;
    this.#drag = null;
    if (drag.moved) this.state.change(drag.id, {}, false);
  }

  #put({ id, name, depth, ball }, x, y, moving) {
    const { camera } = this.state;
    const at = ball ? onBall(camera, x, y, ball) : unproject(camera, x, y, depth);
    this.state.change(id, this.#grip(id, name).move(at), moving);
  }

  #wheel(event, id, name) {
    event.preventDefault();
    event.stopPropagation();
    const factor = Math.exp(-Math.sign(event.deltaY) * Math.min(100, Math.abs(event.deltaY)) * 5e-4);
    this.#deeper(id, name, factor, true);
  }

  // Nearer or farther along the line from the eye, so that its place on the picture stays.
  #deeper(id, name, factor, moving) {
    const { at } = this.#grip(id, name);
    const { x, y } = project(this.state.camera, at);
    const depth = this.#depth(at) * factor;
    if (this.#drag) Object.assign(this.#drag, { depth, ball: null });
    this.#put({ id, name, depth }, x, y, moving);
  }

  #key(event, id, name) {
    const steps = {
      ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, -1, 0], ArrowDown: [0, 1, 0],
      PageUp: [0, 0, 1], PageDown: [0, 0, -1],
    };
    if (event.key === " " || event.key === "Enter") {
      event.preventDefault();
      this.state.change(id, { enabled: !this.state.light(id).enabled });
      return;
    }
    const step = steps[event.key];
    if (!step || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    event.stopPropagation();
    const size = 0.01 * (event.altKey ? 0.1 : event.shiftKey ? 5 : 1);
    const { camera } = this.state;
    const { at } = this.#grip(id, name);
    if (step[2]) {
      this.#deeper(id, name, Math.exp(2 * size * step[2]), true);
      return;
    }
    const shift = size * heightAt(camera, this.#depth(at));
    const right = unproject(camera, 1, 0.5, 1);
    const left = unproject(camera, 0, 0.5, 1);
    const top = unproject(camera, 0.5, 0, 1);
    const bottom = unproject(camera, 0.5, 1, 1);
    const across = scale(normalize(sub(right, left)), step[0] * shift);
    const down = scale(normalize(sub(bottom, top)), step[1] * shift);
    this.state.change(id, this.#grip(id, name).move(add(at, add(across, down))), true);
  }
}

function path(d, name) {
  const node = document.createElementNS(SVG, "path");
  node.setAttribute("d", d);
  if (name) node.setAttribute("class", name);
  return node;
}

function glyph(light, name, inside, angle) {
  const circle = document.createElementNS(SVG, "circle");
  for (const [key, value] of Object.entries({ cx: 12, cy: 12, r: name === "target" ? 8 : 7 })) {
    circle.setAttribute(key, value);
  }
  circle.setAttribute("class", name === "target" ? "mark" : "body");
  const off = name === "target" || !light.enabled;
  circle.setAttribute("fill", off ? "transparent" : toHex(light.intensity));
  if (name === "target") return [circle, path("M12 10v4M10 12h4", "mark")];
  if (!inside) {
    const arrow = path("M22 7l5 5-5 5", "mark");
    arrow.setAttribute("transform", `rotate(${angle} 12 12)`);
    return [circle, arrow];
  }
  return [circle, path(MARKS[light.type] ?? "", "mark")];
}
