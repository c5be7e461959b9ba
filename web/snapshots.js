// States to come back to, each with its picture; one of them can be laid over the picture and wiped.

import { element } from "./fields.js";

const THUMBNAIL = 84; // pixels across
const MOST = 24;

export class Snapshots {
  #all = []; // {number, whole, picture, button, compare}
  #taken = 0;
  #laid = null;

  // keep knows the whole state, as a link does.
  constructor(state, find, keep) {
    Object.assign(this, { state, keep, canvas: find("canvas"), list: find("snapshots") });
    Object.assign(this, { over: find("beside"), wipe: find("wipe"), part: find("wipe-part") });
    this.take = find("snapshot-take");
    this.take.addEventListener("click", () => this.#take());
    this.wipe.addEventListener("input", () => this.#wiped());
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
    const thumbnail = element("canvas", {
      width: THUMBNAIL, height: Math.max(1, Math.round((THUMBNAIL * picture.height) / picture.width)),
    });
    const context = thumbnail.getContext("2d", { alpha: false });
    context.imageSmoothingQuality = "high";
    context.drawImage(picture, 0, 0, thumbnail.width, thumbnail.height);
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

  // Lay a snapshot's picture over the left of the live one, as far as the wipe says.
  #lay(one) {
    this.#laid = one;
    this.over.hidden = this.part.hidden = one === null;
    if (one !== null) {
      const { width, height } = one.picture;
      Object.assign(this.over, { width, height });
      this.over.getContext("2d", { alpha: false }).drawImage(one.picture, 0, 0);
      this.over.setAttribute("aria-label", `Snapshot ${one.number}, on the left`);
      this.#wiped();
    }
    for (const { compare } of this.#all) {
      compare.setAttribute("aria-pressed", String(compare === one?.compare));
    }
  }

  #wiped() {
    this.over.style.setProperty("--wipe", `${100 - this.wipe.valueAsNumber}%`);
  }

  #draw() {
    this.list.replaceChildren(...this.#all.map(({ row }) => row));
  }
}
