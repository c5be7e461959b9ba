// Undo and redo of what is changed in the scene: lights, environment, materials; not the view. A step
// back brings back the method that showed what was there.

import { takesText } from "./fields.js";

const MOST = 100; // steps
const KINDS = ["lights", "environment", "materialEdits"];

const same = (a, b) => JSON.stringify(a) === JSON.stringify(b);

export class History {
  #past = [];
  #future = [];
  #now = {};

  constructor(state, { undo, redo }) {
    Object.assign(this, { state, undoButton: undo, redoButton: redo });
    undo.addEventListener("click", () => this.#back());
    redo.addEventListener("click", () => this.#forth());
    document.addEventListener("keydown", (event) => this.#key(event));
    // What keys and wheels move has no end of its own: it is over when they are let go, or when the
    // hand turns to something else.
    for (const end of ["keyup", "pointerdown"]) {
      document.addEventListener(end, () => this.#record(), true);
    }
    state.listen((what, moving) => {
      if (what === "scene") this.#begin();
      else if (what === "method") this.#shown();
      else if (KINDS.includes(what) && !moving) this.#record();
      else this.#draw();
    });
  }

  // What the state holds is replaced and never written into, so that a step is a few references.
  get #present() {
    const { method } = this.state;
    return { ...Object.fromEntries(KINDS.map((kind) => [kind, this.state[kind]])), method };
  }

  get #pending() {
    return KINDS.some((kind) => this.state[kind] !== this.#now[kind]);
  }

  #begin() {
    this.#past = [];
    this.#future = [];
    this.#now = this.#present;
    this.#draw();
  }

  // Another method shows what is there, which is no step; if the hand is at something, it is one soon.
  #shown() {
    if (!this.#pending) this.#now = this.#present;
    this.#draw();
  }

  // What has changed since the last step is a step.
  #record() {
    if (this.#pending) {
      const before = this.#now;
      this.#now = this.#present;
      if (KINDS.some((kind) => !same(before[kind], this.#now[kind]))) {
        this.#past = [...this.#past, before].slice(-MOST);
        this.#future = [];
      }
    }
    this.#draw();
  }

  #back() {
    this.#go(() => {
      if (!this.#past.length) return;
      this.#future.push(this.#now);
      this.#now = this.#past.pop();
    });
  }

  #forth() {
    this.#go(() => {
      if (!this.#future.length) return;
      this.#past.push(this.#now);
      this.#now = this.#future.pop();
    });
  }

  #go(step) {
    // A control in focus keeps what the hand is at: it lets go to show another value.
    const held = document.activeElement;
    held?.blur();
    this.#record();
    step();
    if (this.#pending) {
      this.state.setMethod(this.#now.method);
      this.state.restore(this.#now);
    }
    held?.focus({ preventScroll: true });
    this.#draw();
  }

  #key(event) {
    if (!(event.ctrlKey || event.metaKey) || event.altKey || takesText(event.target)) return;
    const key = event.key.toLowerCase();
    if (key !== "z" && key !== "y") return;
    event.preventDefault();
    if (key === "y" || event.shiftKey) this.#forth();
    else this.#back();
  }

  #draw() {
    this.undoButton.disabled = !this.#past.length && !this.#pending;
    this.redoButton.disabled = !this.#future.length;
  }
}
