// Handles over the picture, where the lights are: drag across, wheel or Shift-drag for depth, keys.
// What is done to one light of several that are selected is done to all of them.

import { basis, heightAt, onBall, onLine, project, unproject } from "./camera.js";
import { toHex } from "./colour.js";
import { glyph, path, SVG } from "./glyphs.js";
import { gripsOf, SIZE_NAMES } from "./grips.js";
import { spread, toggleOn } from "./light_actions.js";
import { outline } from "./outline.js";
import { add, length, scale, sub } from "./vector.js";

const MARGIN = 0.035; // of the picture, for lights outside it
const SLIP = 4; // pixels of the screen that a hand may slip when it only selects
const APART = 28; // pixels that a grip of a size keeps from what it is the size of
const GROW = 5; // so much more, in logarithms, does a key change a size than a place

export class Handles {
  #nodes = new Map();
  #drag = null;

  // adding() tells whether a tap adds to what is selected.
  constructor(state, { picture, handles, lines }, adding) {
    this.state = state;
    this.adding = adding;
    this.picture = picture;
    this.box = handles;
    this.lines = lines;
    this.lines.setAttribute("viewBox", "0 0 1 1");
    this.lines.setAttribute("preserveAspectRatio", "none");
    this.size = [1, 1]; // of the picture on the screen
    new ResizeObserver(([{ contentRect: { width, height } }]) => {
      this.size = [width, height];
      if (state.scene) this.draw();
    }).observe(picture);
  }

  // Put every handle and line where it belongs; keep the nodes, so that focus stays.
  draw() {
    const { state } = this;
    const wanted = new Set();
    const paths = [];
    for (const light of state.lights) {
      const inHand = light.id === state.selected;
      for (const grip of gripsOf(light, state.scene, state.camera, inHand)) {
        const key = `${light.id} ${grip.name}`;
        wanted.add(key);
        if (!this.#nodes.has(key)) this.#nodes.set(key, this.#make(light.id, grip.name));
        this.#place(this.#nodes.get(key), light, grip, state.selection.includes(light.id));
      }
      if (inHand) paths.push(...outline(light, state.camera));
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

  // The handle of the light that was selected last.
  get current() {
    const { selected } = this.state;
    return this.#nodes.get(`${selected} position`) ?? this.#nodes.get(`${selected} direction`);
  }

  #make(id, name) {
    const node = document.createElement("button");
    node.type = "button";
    const kinds = { position: "source", direction: "source", target: "target" };
    node.className = `handle ${kinds[name] ?? "size"}`;
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
    node.addEventListener("focus", () => {
      if (!this.#drag) this.state.take(id);
    });
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
    if (grip.line) {
      [px, py] = this.#apart(grip.line, x, y);
      // A size whose grip is not in the picture, or that runs away from the eye, is typed.
      node.hidden = !inside || px === null;
      if (node.hidden) return;
    }
    node.style.left = `${100 * px}%`;
    node.style.top = `${100 * py}%`;
    node.classList.toggle("selected", selected);
    node.classList.toggle("off", !light.enabled || !this.state.takes("lights"));
    node.classList.toggle("locked", Boolean(light.locked));
    node.dataset.outside = String(!inside);
    const drawn = `${inside}${light.type}${light.enabled}${toHex(light.intensity)}${Math.round(angle)}`;
    if (node.dataset.drawn !== drawn) {
      node.dataset.drawn = drawn;
      node.firstChild.replaceChildren(...glyph(light, grip.name, inside, angle));
    }
    const said = [grip.line
      ? `${SIZE_NAMES[grip.name] ?? grip.name} ${light[grip.name].toPrecision(3)}`
      : `${grip.name} ${grip.at.map((v) => v.toFixed(2)).join(", ")}`];
    if (!light.enabled) said.unshift("off");
    if (light.locked) said.unshift("locked");
    if (!inside) said.push("outside the picture");
    const tips = { target: " aims here", position: "", direction: "" };
    const tip = tips[grip.name] ?? `: ${said.at(-1)}`;
    node.title = `${light.id}${tip}${light.locked ? ", locked" : ""}${inside ? "" : ", outside the picture"}`;
    const how = grip.line ? "Arrow keys change it." : "Arrow keys move it, page keys change its depth.";
    node.setAttribute("aria-label", `Light ${light.id}, ${said.join(", ")}. ${how}`);
  }

  // A grip of a size stands where its line ends, but never on what it is the size of.
  #apart({ origin, axis, reach }, x, y) {
    const { camera } = this.state;
    const [wide, high] = this.size;
    const from = project(camera, origin);
    const [dx, dy] = [(x - from.x) * wide, (y - from.y) * high];
    const off = Math.hypot(dx, dy);
    if (off >= APART || from.depth <= 0) return [x, y];
    const far = project(camera, add(origin, scale(axis, Math.max(reach, 1e-6) * 1.5)));
    const [ux, uy] = [(far.x - from.x) * wide, (far.y - from.y) * high];
    const long = Math.hypot(ux, uy);
    if (long < 0.5) return [null, null];
    return [from.x + ((ux / long) * APART) / wide, from.y + ((uy / long) * APART) / high];
  }

  #grip(id, name) {
    const { state } = this;
    const grips = gripsOf(state.light(id), state.scene, state.camera, true);
    return grips.find((grip) => grip.name === name);
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
    const { at, ball, line } = this.#grip(id, name);
    const depth = this.#depth(at);
    const [x, y] = this.#at(event);
    const shown = project(this.state.camera, at);
    // Held where it was touched, unless it comes in from outside.
    const hold = node.dataset.outside === "true" ? [0, 0] : [shown.x - x, shown.y - y];
    // With a key held, or adding, it is only selected, unless it is dragged then.
    const more = event.ctrlKey || event.metaKey || event.shiftKey || this.adding();
    const [start, pointer] = [[event.clientX, event.clientY], event.pointerId];
    this.#drag = { id, name, depth, ball, line, hold, more, start, pointer, last: [x, y], moved: false };
    node.focus({ preventScroll: true });
    if (!more) this.state.take(id);
  }

  // What this pointer drags; null where its light has gone meanwhile.
  #held({ pointerId }) {
    const drag = this.#drag;
    return drag?.pointer === pointerId && this.state.light(drag.id) ? drag : null;
  }

  #move(event) {
    const drag = this.#held(event);
    if (!drag) return;
    const [x, y] = this.#at(event);
    if (x === drag.last[0] && y === drag.last[1]) return;
    const [sx, sy] = drag.start;
    if (drag.more && Math.hypot(event.clientX - sx, event.clientY - sy) <= SLIP) return;
    if (drag.more) this.state.take(drag.id);
    drag.more = false;
    if (event.shiftKey && !drag.line) {
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
    const drag = this.#held(event);
    if (this.#drag?.pointer === event.pointerId) this.#drag = null;
    if (!drag) return;
    if (drag.moved) this.state.change(drag.id, {}, false);
    else if (event.type === "pointerup") this.state.select(drag.id, drag.more);
  }

  #put({ id, name, depth, ball, line }, x, y, moving) {
    const { camera } = this.state;
    const { move } = this.#grip(id, name);
    const at = ball ? onBall(camera, x, y, ball)
      : line ? onLine(camera, x, y, line) : unproject(camera, x, y, depth);
    if (at !== null) this.#change(id, move(at), moving);
  }

  // One that is locked holds all of them.
  #change(id, fields, moving) {
    const { state } = this;
    if (!state.light(id).locked) state.changeAll(spread(state, id, fields), moving);
  }

  #wheel(event, id, name) {
    event.preventDefault();
    event.stopPropagation();
    const factor = Math.exp(-Math.sign(event.deltaY) * Math.min(100, Math.abs(event.deltaY)) * 5e-4);
    this.#deeper(id, name, factor, true);
  }

  // Nearer or farther along the line from the eye, so that its place on the picture stays.
  #deeper(id, name, factor, moving) {
    const { at, line, move } = this.#grip(id, name);
    if (line) {
      this.#change(id, move(line.reach * factor), moving);
      return;
    }
    const { x, y } = project(this.state.camera, at);
    const depth = this.#depth(at) * factor;
    if (this.#drag) Object.assign(this.#drag, { depth, ball: null });
    this.#put({ id, name, depth }, x, y, moving);
  }

  // A key for the light that is selected, wherever the focus is.
  key(event) {
    const { current } = this;
    if (current) this.#key(event, current.dataset.light, current.dataset.grip);
  }

  #key(event, id, name) {
    const steps = {
      ArrowLeft: [-1, 0, 0], ArrowRight: [1, 0, 0], ArrowUp: [0, -1, 0], ArrowDown: [0, 1, 0],
      PageUp: [0, 0, 1], PageDown: [0, 0, -1],
    };
    const plain = !event.ctrlKey && !event.metaKey;
    if (plain && (event.key === " " || event.key === "Enter")) {
      event.preventDefault();
      toggleOn(this.state);
      return;
    }
    const step = steps[event.key];
    if (!step || !plain) return;
    event.preventDefault();
    event.stopPropagation();
    const size = 0.01 * (event.altKey ? 0.1 : event.shiftKey ? 5 : 1);
    const { camera } = this.state;
    const { at, move, line } = this.#grip(id, name);
    if (line) {
      const more = step[0] - step[1] + step[2];
      this.#change(id, move(line.reach * Math.exp(GROW * size * more)), true);
      return;
    }
    if (step[2]) {
      this.#deeper(id, name, Math.exp(2 * size * step[2]), true);
      return;
    }
    const shift = size * heightAt(camera, this.#depth(at));
    const { right, up } = basis(camera);
    const moved = add(scale(right, step[0] * shift), scale(up, -step[1] * shift));
    this.#change(id, move(add(at, moved)), true);
  }
}
