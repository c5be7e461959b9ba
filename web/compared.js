// A snapshot beside the live picture: laid over its left part, as far as a slider says, or next to it.

export class Compared {
  // over lies on the picture, apart stands beside it in the stage.
  constructor({ over, apart, stage, part, wipe, beside }) {
    Object.assign(this, { over, apart, stage, part, wipe, beside });
    this.picture = null;
    wipe.addEventListener("input", () => this.#wiped());
    beside.addEventListener("change", () => this.#draw());
  }

  // {picture, number} or null.
  show(snapshot) {
    this.picture = snapshot?.picture ?? null;
    if (snapshot) {
      const { width, height } = this.picture;
      for (const [canvas, where] of [[this.over, "on the left"], [this.apart, "beside the picture"]]) {
        Object.assign(canvas, { width, height });
        canvas.getContext("2d", { alpha: false }).drawImage(this.picture, 0, 0);
        canvas.setAttribute("aria-label", `Snapshot ${snapshot.number}, ${where}`);
      }
      this.apart.style.setProperty("--ratio", width / height);
    }
    this.#draw();
  }

  #draw() {
    const shown = this.picture !== null;
    const { checked: beside } = this.beside;
    this.part.hidden = !shown;
    this.over.hidden = !shown || beside;
    this.apart.hidden = !shown || !beside;
    this.wipe.disabled = beside;
    this.stage.classList.toggle("two", shown && beside);
    this.#wiped();
  }

  #wiped() {
    this.over.style.setProperty("--wipe", `${100 - this.wipe.valueAsNumber}%`);
  }
}
