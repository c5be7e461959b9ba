// States to come back to, each with its picture; one of them can be compared with the live one.

import { Compared } from "./compared.js";
import { element } from "./fields.js";

const THUMBNAIL = 84; // pixels of the page across
const MOST = 24;

export class Snapshots {
  #all = []; // {number, whole, picture, button, compare}
  #taken = 0;
  #laid = null;

  // keep knows the whole state, as a link does.
  constructor(state, find, keep) {
    Object.assign(this, { state, keep, canvas: find("canvas"), list: find("snapshots") });
    this.compared = new Compared({
      over: find("beside"), apart: find("apart"), stage: find("stage"), part: find("compared-part"),
      wipe: find("wipe"), beside: find("side-by-side"),
    });
    this.take = find("snapshot-take");
    this.take.addEventListener("click", () => this.#take());
    // Those of one scene: the state of another is none of this one's.
    state.listen((what) => {
      if (what === "scene") this.#forget();
    });
  }

  #forget() {
    this.#lay(null);
    for (const { picture } of this.#all) picture.close();
    this.#all = [];
    this.#draw();
  }

  async #take() {
    const { scene } = this.state;
    const whole = structuredClone(this.keep.whole);
    const picture = await createImageBitmap(this.canvas);
    if (scene !== this.state.scene) return;
    this.#taken += 1;
    this.#all = [...this.#all, this.#made(this.#taken, whole, picture)];
    while (this.#all.length > MOST) this.#remove(this.#all[0]);
    this.#draw();
  }

  #made(number, whole, picture) {
    const one = { number, whole, picture };
    const width = Math.min(picture.width, Math.round(THUMBNAIL * devicePixelRatio));
    const height = Math.max(1, Math.round((width * picture.height) / picture.width));
    const thumbnail = element("canvas", { width, height });
    const context = thumbnail.getContext("2d", { alpha: false });
    context.imageSmoothingQuality = "high";
    context.drawImage(picture, 0, 0, width, height);
    const button = (text, label, act) => {
      const made = element("button", { type: "button", textContent: text });
      made.setAttribute("aria-label", `${label} snapshot ${number}`);
      made.addEventListener("click", act);
      return made;
    };
    const back = button("", "Go back to", () => this.keep.restore(one.whole));
    back.className = "back";
    back.append(thumbnail);
    one.compare = button("Compare", "Compare with", () => this.#lay(this.#laid === one ? null : one));
    const remove = button("×", "Remove", () => {
      this.#remove(one);
      this.#draw();
      this.take.focus();
    });
    one.row = element("li");
    one.row.append(back, one.compare, remove);
    return one;
  }

  #remove(one) {
    if (this.#laid === one) this.#lay(null);
    one.picture.close();
    this.#all = this.#all.filter((other) => other !== one);
  }

  #lay(one) {
    this.#laid = one;
    this.compared.show(one);
    for (const { compare } of this.#all) {
      compare.setAttribute("aria-pressed", String(compare === one?.compare));
    }
  }

  #draw() {
    this.list.replaceChildren(...this.#all.map(({ row }) => row));
  }
}
