// What the reference shows of the same edits: rendered beside, then compared with the picture.

import { percent, unit } from "./front_chart.js";
import { JobRow } from "./job.js";
import { post } from "./materials.js";
import { NAMES } from "./status.js";

const PICTURES = { live: "Live", reference: "Reference", difference: "Difference" };
const EDITS = new Set(["lights", "environment", "materials", "materialEdits", "restored", "camera", "settings"]);

export class Reference {
  #job = null; // what the pictures are of
  #done = false; // whether they are there
  #asked = 0;
  #words = "";

  constructor(state, find, { call }) {
    const names = ["ask", "told", "again", "close", "pictures", "legend", "over"];
    for (const name of names) this[name] = find(`reference-${name}`);
    Object.assign(this, { state, call, box: find("reference") });
    this.row = new JobRow(find("reference-progress"), call, () => "Path tracing:");
    this.figures = Object.entries(PICTURES).map(([which, name]) => this.#figure(which, name));
    this.pictures.replaceChildren(...this.figures);
    for (const button of [this.ask, this.again]) button.addEventListener("click", () => this.#ask());
    this.close.addEventListener("click", () => this.leave());
    document.addEventListener("keydown", (event) => {
      if (event.key !== "Escape" || this.box.hidden) return;
      event.preventDefault();
      this.leave();
    });
  }

  #figure(which, name) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", title: `${name}: show it in place of the picture` });
    button.dataset.which = which;
    button.setAttribute("aria-pressed", "false");
    const image = new Image();
    image.alt = "";
    button.append(image, Object.assign(document.createElement("span"), { textContent: name }));
    button.addEventListener("click", () => {
      this.#lay(button.getAttribute("aria-pressed") === "true" ? null : button);
    });
    return button;
  }

  // Lay one of the pictures over the live one, or none.
  #lay(chosen) {
    for (const figure of this.figures) figure.setAttribute("aria-pressed", String(figure === chosen));
    this.over.hidden = !chosen;
    if (!chosen) return;
    this.over.src = chosen.querySelector("img").src;
    this.over.alt = chosen.textContent;
  }

  // Something has changed.
  changed(what, moving) {
    if (what === "scene" || what === "method") this.leave();
    if (!this.#job) return;
    if (EDITS.has(what)) {
      this.#lay(null);
      this.box.classList.add("stale");
      this.#tell();
    }
    if (what === "exposure" && !moving && this.#done) this.#show();
  }

  // Close it, and give up what goes on.
  leave() {
    this.#asked += 1;
    this.row.cancel();
    this.row.leave();
    this.#job = null;
    this.#done = false;
    this.#lay(null);
    if (this.box.contains(document.activeElement)) this.ask.focus();
    this.box.hidden = true;
  }

  async #ask() {
    this.leave();
    const asked = this.#asked;
    const { state, box } = this;
    const { method } = state;
    const query = new URLSearchParams({ method, settings: JSON.stringify(state.settings) });
    const path = `api/scenes/${encodeURIComponent(state.scene.name)}/reference?${query}`;
    const job = await this.call(path, post(state.edits()));
    if (asked !== this.#asked) {
      this.call(`api/jobs/${job.id}`, { method: "DELETE" }).catch(() => {});
      return;
    }
    this.#job = job;
    box.hidden = false;
    box.classList.remove("stale");
    this.#words = "";
    this.#tell();
    this.pictures.hidden = this.legend.hidden = true;
    this.close.focus();
    this.row.follow(job, (ended) => this.#ended(ended));
  }

  #ended({ status, problem }) {
    this.#done = status === "done";
    if (this.#done) this.#show();
    else if (problem) {
      this.#words = problem.detail;
      this.#tell();
    } else this.leave();
  }

  async #show() {
    const job = this.#job;
    const at = `api/jobs/${job.id}/reference`;
    const query = new URLSearchParams({ exposure: this.state.exposure });
    const result = await this.call(`${at}?${query}`);
    if (job !== this.#job) return;
    this.#words = words(result);
    this.#tell();
    for (const figure of this.figures) {
      const image = figure.querySelector("img");
      image.src = `${at}/${figure.dataset.which}?${query}`;
      if (figure.getAttribute("aria-pressed") === "true") this.over.src = image.src;
    }
    const full = percent(result.full);
    this.legend.querySelector(".low").textContent = `−${full}: too dark`;
    this.legend.querySelector(".high").textContent = `too bright: +${full} of the mean`;
    const n = result.averaged;
    const averaged = n > 1 ? `, each place the mean of ${n} × ${n} pixels: single ones are noise` : "";
    this.legend.querySelector(".none").textContent = `edges and lamps left out${averaged}`;
    this.pictures.hidden = this.legend.hidden = false;
  }

  #tell() {
    const stale = this.box.classList.contains("stale");
    this.told.textContent = stale && this.#words ? `Before the last change: ${this.#words}` : this.#words;
    this.again.hidden = !stale || this.row.active;
  }
}

function words({ method, verdict: { error, least, psnr, noise }, samples, seconds }) {
  if (error === null || least === null) return "The reference is black: there is nothing to compare with.";
  const off = error > least ? percent(error) : `under ${percent(least)}`;
  const alike = psnr === null ? "no difference on the screen" : unit(psnr, "dB");
  return (
    `${NAMES[method] ?? method}: ${off} off (relative L2, edges and lamps left out), ${alike}; ` +
    `the reference's own noise is ${percent(noise)} (${samples} samples a pixel, ${Math.round(seconds)} s).`
  );
}
