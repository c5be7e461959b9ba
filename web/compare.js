// For as long as a key or a button is held the picture shows the scene's own materials. It is another
// picture over the one of the edits, which stays as it is.

import { takesLetters } from "./fields.js";

const PRESSED = new Set([" ", "Enter"]);

export class Compare {
  #held = false;
  #kept = ""; // what the picture before shows

  // canvas has the picture of the edits, before another one; ask({edits, exposure, method,
  // settings}) resolves to a picture.
  constructor(state, { button, canvas, before }, ask) {
    Object.assign(this, { state, button, canvas, before, ask });
    button.addEventListener("pointerdown", (event) => this.#hold(event.button === 0));
    button.addEventListener("keydown", ({ key }) => {
      if (PRESSED.has(key)) this.#hold(true);
    });
    button.addEventListener("keyup", () => this.#hold(false));
    document.addEventListener("keydown", (event) => {
      const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
      if (isB(event) && plain && !takesLetters(event.target)) this.#hold(true);
    });
    document.addEventListener("keyup", (event) => {
      if (isB(event)) this.#hold(false);
    });
    // Wherever the hand lets go, and if it does so in another window.
    for (const end of ["pointerup", "pointercancel"]) {
      document.addEventListener(end, () => this.#hold(false));
    }
    window.addEventListener("blur", () => this.#hold(false));
  }

  // The canvas has its final picture: where no material is edited it is the one to go back to.
  keep() {
    if (this.state.edits().materials) return;
    this.#take(this.canvas, JSON.stringify(this.#wanted()));
  }

  // Everything as it is now but for the materials, and what draws it: a preview is no picture to
  // compare with.
  #wanted() {
    const { state, canvas } = this;
    const { materials: _, ...edits } = state.edits();
    const { exposure, method, settings, scene } = state;
    const { method: drawn, preview } = canvas.dataset;
    return { edits, exposure, method, settings, scene: scene.name, drawn, preview };
  }

  #take(picture, kept) {
    const { width, height } = picture;
    Object.assign(this.before, { width, height });
    this.before.getContext("2d", { alpha: false }).drawImage(picture, 0, 0);
    this.#kept = kept;
  }

  async #hold(on) {
    const held = Boolean(on && this.state.takes("materials"));
    if (held === this.#held) return;
    this.#held = held;
    this.button.setAttribute("aria-pressed", String(held));
    if (held) await this.#fetch().catch(() => {});
    this.before.hidden = !this.#held || this.#kept !== JSON.stringify(this.#wanted());
  }

  async #fetch() {
    const wanted = this.#wanted();
    const kept = JSON.stringify(wanted);
    if (kept === this.#kept) return;
    const picture = await this.ask(wanted);
    this.#take(picture, kept);
    picture.close();
  }
}

const isB = ({ key }) => key.toLowerCase() === "b";
