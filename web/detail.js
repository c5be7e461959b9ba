// How far the camera stands, and what picks the level of detail of measured materials.

import { dolly } from "./camera.js";
import { element } from "./fields.js";
import { length, sub } from "./vector.js";

const NEAREST = -2; // log2 of the distance to the target, as a part of the scene's own camera's
const FARTHEST = 6;
const HINTS = {
  distance: "Farther off, the materials are put together from coarser levels: highlights do not sparkle.",
  footprint: "Where directions turn fast from a pixel to the next, the levels are coarser.",
  finest: "Everything at its finest level: from afar highlights may sparkle.",
};

export class Detail {
  constructor(state, { part, far, farValue, near, away, detailPart, detail, levels, legend, hint }) {
    Object.assign(this, { state, part, far, farValue, detailPart, detail, levels, legend, hint });
    Object.assign(far, { min: NEAREST, max: FARTHEST, step: 0.05 });
    far.addEventListener("input", () => this.#go(far.valueAsNumber, true));
    far.addEventListener("change", () => this.#go(far.valueAsNumber, false));
    near.addEventListener("click", () => this.#go(NEAREST / 2, false));
    away.addEventListener("click", () => this.#go(FARTHEST / 2, false));
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
    this.levels.checked = settings.show === "levels";
    this.legend.hidden = !this.levels.checked;
    this.hint.textContent = HINTS[settings.detail];
  }
}
