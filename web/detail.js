// How far the camera stands, and what picks the level of detail of measured materials.

import { dolly } from "./camera.js";
import { element } from "./fields.js";
import { length, sub } from "./vector.js";

const NEAREST = -2; // log2 of the distance to the target, as a part of the scene's own camera's
const FARTHEST = 6;
const ALPHAS = [-3, 4]; // log2 of the scene's diagonals up to which all is finest
const HINTS = {
  distance: "Farther off, the materials are put together from coarser levels: highlights do not sparkle.",
  footprint: "Where directions turn fast from a pixel to the next, the levels are coarser.",
  finest: "Everything at its finest level: from afar highlights may sparkle.",
};

export class Detail {
  constructor(state, { part, far, farValue, near, away, detailPart, detail, levels, legend, hint, ...alpha }) {
    Object.assign(this, { state, part, far, farValue, detailPart, detail, levels, legend, hint, ...alpha });
    Object.assign(far, { min: NEAREST, max: FARTHEST, step: 0.05 });
    far.addEventListener("input", () => this.#go(far.valueAsNumber, true));
    far.addEventListener("change", () => this.#go(far.valueAsNumber, false));
    near.addEventListener("click", () => this.#go(NEAREST / 2, false));
    away.addEventListener("click", () => this.#go(FARTHEST / 2, false));
    Object.assign(this.alpha, { min: ALPHAS[0], max: ALPHAS[1], step: 0.1 });
    for (const [event, moving] of [["input", true], ["change", false]]) {
      this.alpha.addEventListener(event, () =>
        state.setSettings({ alpha: 2 ** -this.alpha.valueAsNumber }, moving),
      );
    }
    detail.addEventListener("change", () => state.setSettings({ detail: detail.value }));
    levels.addEventListener("change", () =>
      state.setSettings({ show: levels.checked ? "levels" : "radiance" }),
    );
    detail.append(
      ...Object.keys(HINTS).map((name) => element("option", { value: name, textContent: name })),
    );
  }

  // log2 of how many times as far as the scene's own camera.
  get #distance() {
    const reach = ({ position, target }) => length(sub(position, target));
    return Math.log2(reach(this.state.camera) / reach(this.state.scene.camera));
  }

  #go(distance, moving) {
    const { state } = this;
    state.setCamera(dolly(state.camera, 2 ** (distance - this.#distance)), moving);
  }

  draw() {
    const { state } = this;
    this.part.hidden = !state.takes("camera");
    const { settings } = state;
    this.detailPart.hidden = settings.detail === undefined;
    const distance = this.#distance;
    if (document.activeElement !== this.far) this.far.value = distance;
    const told = `${Number((2 ** distance).toPrecision(2))} ×`;
    this.farValue.textContent = told;
    this.far.setAttribute("aria-valuetext", told);
    if (this.detailPart.hidden) return;
    this.detail.value = settings.detail;
    this.alphaPart.hidden = settings.detail !== "distance";
    if (document.activeElement !== this.alpha) this.alpha.value = -Math.log2(settings.alpha);
    this.alphaValue.textContent = `${Number((1 / settings.alpha).toPrecision(2))} × scene`;
    this.alpha.setAttribute("aria-valuetext", this.alphaValue.textContent);
    this.levels.checked = settings.show === "levels";
    this.legend.hidden = !this.levels.checked;
    this.hint.textContent = HINTS[settings.detail];
  }
}
