// The camera by hand: right button, or any button in camera mode; keys on the focused picture. With
// Alt held the environment turns instead.

import { dolly, orbit, pan } from "./camera.js";

const TURN = Math.PI; // for a drag across the picture
const SETTLE_MS = 350; // wheel and keys have no end of their own

export class Orbit {
  #drag = null;
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
      const typing = event.target.matches?.("input, select, textarea");
      const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
      if (event.key.toLowerCase() === "c" && plain && !typing) this.setMode(!this.mode);
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
    if (!this.state.camera || !(event.button === 2 || (this.mode && event.button === 0))) return;
    if (event.target.closest(".progress")) return;
    event.preventDefault();
    this.picture.setPointerCapture(event.pointerId);
    const sky = event.altKey && this.state.environment !== null;
    this.#drag = { pointer: event.pointerId, x: event.clientX, y: event.clientY, moved: false, sky };
  }

  #move(event) {
    const drag = this.#drag;
    if (!drag || drag.pointer !== event.pointerId) return;
    const box = this.picture.getBoundingClientRect();
    const dx = (event.clientX - drag.x) / box.height;
    const dy = (event.clientY - drag.y) / box.height;
    if (!dx && !dy) return;
    Object.assign(drag, { x: event.clientX, y: event.clientY, moved: true });
    if (drag.sky) {
      this.#turnSky(dx, true);
      return;
    }
    const { camera } = this.state;
    this.state.setCamera(
      event.shiftKey ? pan(camera, dx, dy) : orbit(camera, -TURN * dx, TURN * dy),
      true,
    );
  }

  // The environment follows the hand, as seen from the camera.
  #turnSky(dx, moving) {
    const { environment } = this.state;
    const angle = environment.rotation_degrees + (TURN * dx * 180) / Math.PI;
    this.state.setEnvironment({ ...environment, rotation_degrees: angle }, moving);
  }

  #up(event) {
    if (this.#drag?.pointer !== event.pointerId) return;
    const { moved, sky } = this.#drag;
    this.#drag = null;
    if (moved && sky) this.#turnSky(0, false);
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
    const angle = (event.altKey ? 0.2 : event.shiftKey ? 10 : 2) * (Math.PI / 180);
    const { camera } = this.state;
    const moves = {
      ArrowLeft: () => orbit(camera, -angle, 0),
      ArrowRight: () => orbit(camera, angle, 0),
      ArrowUp: () => orbit(camera, 0, angle),
      ArrowDown: () => orbit(camera, 0, -angle),
      PageUp: () => dolly(camera, 1 - angle),
      PageDown: () => dolly(camera, 1 + angle),
    };
    if (!moves[event.key]) return;
    event.preventDefault();
    this.#step(moves[event.key]());
  }

  #step(camera) {
    this.state.setCamera(camera, true);
    clearTimeout(this.#settle);
    this.#settle = setTimeout(() => this.state.setCamera(this.state.camera, false), SETTLE_MS);
  }
}
