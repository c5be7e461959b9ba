// The camera by hand: right button, or any button in camera mode; keys on the focused picture. With
// Alt held the environment turns instead.

import { dolly, orbit, pan } from "./camera.js";
import { takesLetters } from "./fields.js";

const TURN = Math.PI; // for a drag across the picture
const SHIFT = 0.02; // of the picture's height, for a key
const NEARER = 0.95; // for a key
const SETTLE_MS = 350; // wheel and keys have no end of their own

export class Orbit {
  #drag = null;
  #fingers = new Map();
  #settle = 0;

  constructor(state, picture, toggle) {
    Object.assign(this, { state, picture, toggle });
    picture.addEventListener("contextmenu", (event) => event.preventDefault());
    picture.addEventListener("pointerdown", (event) => this.#down(event));
    picture.addEventListener("pointermove", (event) => this.#move(event));
    for (const end of ["pointerup", "pointercancel"]) {
      picture.addEventListener(end, (event) => this.#up(event));
    }
    picture.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
    picture.addEventListener("keydown", (event) => this.#key(event));
    toggle.addEventListener("click", () => this.setMode(!this.mode));
    document.addEventListener("keydown", (event) => {
      const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
      if (event.key.toLowerCase() === "c" && plain && !takesLetters(event.target)) {
        this.setMode(!this.mode);
      }
    });
  }

  get mode() {
    return this.toggle.getAttribute("aria-pressed") === "true";
  }

  setMode(on) {
    this.toggle.setAttribute("aria-pressed", String(on));
    this.picture.classList.toggle("orbiting", on);
  }

  #down(event) {
    const { button } = event;
    if (!this.state.camera || !(button === 1 || button === 2 || (this.mode && button === 0))) return;
    if (event.target.closest(".progress")) return;
    event.preventDefault();
    this.picture.focus({ preventScroll: true });
    this.picture.setPointerCapture(event.pointerId);
    this.#fingers.set(event.pointerId, [event.clientX, event.clientY]);
    if (this.#fingers.size > 1) return;
    const what = button === 1 ? "shift" : event.altKey && this.state.environment ? "sky" : "turn";
    this.#drag = { what, moved: false };
  }

  #move(event) {
    const last = this.#fingers.get(event.pointerId);
    if (!last) return;
    const box = this.picture.getBoundingClientRect();
    const now = [event.clientX, event.clientY];
    const [dx, dy] = [0, 1].map((axis) => (now[axis] - last[axis]) / box.height);
    if (!dx && !dy) return;
    const apart = this.#apart();
    this.#fingers.set(event.pointerId, now);
    this.#drag.moved = true;
    const { camera } = this.state;
    if (this.#fingers.size > 1) {
      // Two fingers: what lies between them grows and moves along.
      const nearer = dolly(camera, apart / Math.max(1, this.#apart()));
      this.state.setCamera(pan(nearer, dx / 2, dy / 2), true);
    } else if (this.#drag.what === "sky") {
      this.#turnSky(dx, true);
    } else if (this.#drag.what === "shift" || event.shiftKey) {
      this.state.setCamera(pan(camera, dx, dy), true);
    } else {
      this.state.setCamera(orbit(camera, -TURN * dx, TURN * dy), true);
    }
  }

  // Pixels between the first two fingers.
  #apart() {
    const [a, b] = this.#fingers.values();
    return b ? Math.max(1, Math.hypot(a[0] - b[0], a[1] - b[1])) : 1;
  }

  // The environment follows the hand, as seen from the camera.
  #turnSky(dx, moving) {
    const { environment } = this.state;
    const angle = environment.rotation_degrees + (TURN * dx * 180) / Math.PI;
    this.state.setEnvironment({ ...environment, rotation_degrees: angle }, moving);
  }

  #up(event) {
    if (!this.#fingers.delete(event.pointerId) || this.#fingers.size) return;
    const { moved, what } = this.#drag;
    this.#drag = null;
    if (moved && what === "sky") this.#turnSky(0, false);
    else if (moved) this.state.setCamera(this.state.camera, false);
  }

  #wheel(event) {
    if (!this.state.camera || !this.mode) return;
    event.preventDefault();
    const by = Math.sign(event.deltaY) * Math.min(100, Math.abs(event.deltaY));
    this.#step(dolly(this.state.camera, Math.exp(1e-3 * by)));
  }

  #key(event) {
    if (event.target !== this.picture || !this.state.camera || event.ctrlKey || event.metaKey) return;
    const angle = (event.altKey ? 0.2 : 2) * (Math.PI / 180);
    const by = (x, y) => (camera) =>
      event.shiftKey ? pan(camera, -x * SHIFT, y * SHIFT) : orbit(camera, x * angle, y * angle);
    const moves = {
      ArrowLeft: by(-1, 0),
      ArrowRight: by(1, 0),
      ArrowUp: by(0, 1),
      ArrowDown: by(0, -1),
      PageUp: (camera) => dolly(camera, NEARER),
      PageDown: (camera) => dolly(camera, 1 / NEARER),
      "+": (camera) => dolly(camera, NEARER),
      "-": (camera) => dolly(camera, 1 / NEARER),
    };
    if (!moves[event.key]) return;
    event.preventDefault();
    this.#step(moves[event.key](this.state.camera));
  }

  #step(camera) {
    this.state.setCamera(camera, true);
    clearTimeout(this.#settle);
    this.#settle = setTimeout(() => this.state.setCamera(this.state.camera, false), SETTLE_MS);
  }
}
