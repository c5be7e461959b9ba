// Keys for the lights that are selected, wherever the focus is, and the list of all keys.

import { takesLetters } from "./fields.js";
import { duplicate, solo, toggleLock, toggleOn } from "./light_actions.js";

const ARROWS = new Set(["ArrowLeft", "ArrowRight", "ArrowUp", "ArrowDown", "PageUp", "PageDown"]);
// Where keys are for something else.
const ELSEWHERE = "#environment-part, #editor-part, #materials-part, #snapshots, #reference, dialog";

export class Keys {
  constructor(state, { dialog, open, close }, { handles, list }) {
    Object.assign(this, { state, dialog, handles, list });
    open.addEventListener("click", () => dialog.showModal());
    close.addEventListener("click", () => dialog.close());
    document.addEventListener("keydown", (event) => this.#key(event));
  }

  #key(event) {
    const { target } = event;
    if (event.defaultPrevented || this.dialog.open || event.altKey || takesLetters(target)) return;
    const control = event.ctrlKey || event.metaKey;
    const act = control ? this.#controlled(event) : this.#plain(event);
    if (!act || target.closest(ELSEWHERE)) return;
    event.preventDefault();
    act();
  }

  #controlled({ key }) {
    const { state } = this;
    if (key === "a") return () => state.setSelection(this.list.listed);
    if (key === "d" && state.selected) return () => duplicate(state);
    return null;
  }

  #plain(event) {
    const { state, handles, dialog } = this;
    if (event.key === "?") return () => dialog.showModal();
    if (!state.selected) return null;
    // With nothing in focus, arrows are for the light.
    if (ARROWS.has(event.key) && event.target === document.body) return () => handles.key(event);
    return {
      escape: () => state.setSelection([]),
      delete: () => state.remove(state.selection),
      backspace: () => state.remove(state.selection),
      h: () => toggleOn(state),
      s: () => solo(state),
      l: () => toggleLock(state),
      m: () => handles.current?.focus({ preventScroll: true }),
    }[event.key.toLowerCase()];
  }
}
