// A click in the picture picks the material that is there; a drag does not.

import { byHand } from "./follow.js";

const STILL = 4; // pixels of the screen that a hand may slip in a click

export class Picking {
  #down = null;

  // pick(x, y): both from 0 at the left and top edge of the picture to 1.
  constructor(state, picture, pick) {
    Object.assign(this, { state, picture, pick });
    picture.addEventListener("pointerdown", (event) => this.#press(event));
    picture.addEventListener("pointerup", (event) => this.#release(event));
  }

  draw() {
    this.picture.classList.toggle("picking", Boolean(byHand(this.state)));
  }

  #press(event) {
    const { pointerId: id, clientX: x, clientY: y } = event;
    const other = event.altKey || event.ctrlKey || event.metaKey || event.shiftKey;
    const able = byHand(this.state) && !event.target.closest("button, .progress");
    // A second finger makes it another gesture.
    const click = able && event.isPrimary && event.button === 0 && !other;
    this.#down = click ? { id, x, y, camera: this.state.camera } : null;
  }

  #release(event) {
    const down = this.#down;
    this.#down = null;
    if (down?.id !== event.pointerId) return;
    const moved = Math.hypot(event.clientX - down.x, event.clientY - down.y) > STILL;
    if (moved || down.camera !== this.state.camera) return;
    const box = this.picture.getBoundingClientRect();
    const inside = (v) => Math.max(0, Math.min(1, v));
    this.pick(inside((down.x - box.left) / box.width), inside((down.y - box.top) / box.height));
  }
}
