// For as long as a key or a button is held the picture shows the scene's own materials.

import { takesLetters } from "./fields.js";

const PRESSED = new Set([" ", "Enter"]);

export class Compare {
  constructor(state, button) {
    Object.assign(this, { state, button });
    button.addEventListener("pointerdown", (event) => this.#show(event.button === 0));
    button.addEventListener("keydown", ({ key }) => {
      if (PRESSED.has(key)) this.#show(true);
    });
    button.addEventListener("keyup", () => this.#show(false));
    document.addEventListener("keydown", (event) => {
      const plain = !event.ctrlKey && !event.metaKey && !event.altKey;
      if (isB(event) && plain && !takesLetters(event.target)) this.#show(true);
    });
    document.addEventListener("keyup", (event) => {
      if (isB(event)) this.#show(false);
    });
    // Wherever the hand lets go, and if it does so in another window.
    for (const end of ["pointerup", "pointercancel"]) {
      document.addEventListener(end, () => this.#show(false));
    }
    window.addEventListener("blur", () => this.#show(false));
  }

  #show(on) {
    const shown = Boolean(on && this.state.takes("materials"));
    this.button.setAttribute("aria-pressed", String(shown));
    this.state.setComparing(shown);
  }
}

const isB = ({ key }) => key.toLowerCase() === "b";
