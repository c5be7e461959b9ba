// Materials that the method holds fixed: another one is a precompute of its own, which is followed
// here; then the picture changes over to it. What the method makes of each is told beside it.

import { element, group } from "./fields.js";
import { methodFor } from "./follow.js";

const OWN = ""; // as the scene has it
const OFF = 0.5; // error of a fit from which on it is marked, as the service warns

export class Materials {
  #events = null;
  #job = null;
  #wanted = null;

  // call(path, options) asks the service; follow(job) shows a job, null for none.
  constructor(state, { part, list, other }, { call, follow, problem }) {
    Object.assign(this, { state, part, list, call, follow, problem });
    other.addEventListener("click", () => state.setMethod(methodFor(state, "materials").name));
  }

  get #path() {
    return `api/scenes/${encodeURIComponent(this.state.scene.name)}`;
  }

  // By name, whatever their group.
  get #presets() {
    return Object.assign({}, ...Object.values(this.state.scene.material_presets));
  }

  // The scene, the method, its product or the materials are others.
  async refresh() {
    const { state } = this;
    const shown = state.takes("camera") && !state.takes("materials");
    this.part.hidden = !shown;
    if (!shown) return;
    const { scene, method } = state;
    const path = `${this.#path}/materials?method=${encodeURIComponent(method)}`;
    let materials = null;
    try {
      materials = await this.call(path, post({ materials: state.materials }));
    } catch {
      return;
    }
    if (scene !== state.scene || method !== state.method) return;
    if (this.list.children.length !== materials.length || this.list.dataset.scene !== scene.name) {
      this.list.dataset.scene = scene.name;
      this.list.replaceChildren(...materials.map((material, k) => this.#row(material, k)));
    }
    materials.forEach((material, k) => this.#show(this.list.children[k], material));
  }

  // The service has let go of the product of these materials: have it again.
  again() {
    if (!this.#job) this.#ask(this.state.materials);
  }

  // What goes on is for a scene or a method that is no longer looked at.
  leave() {
    this.#end();
  }

  #row({ name }, k) {
    const row = element("li", {});
    const select = element("select", { id: `material-${k}` });
    const label = element("label", { textContent: name, htmlFor: select.id, title: name });
    select.append(new Option("As in the scene", OWN));
    for (const [label, members] of Object.entries(this.state.scene.material_presets)) {
      select.append(group(label, Object.keys(members).map((preset) => new Option(preset))));
    }
    select.addEventListener("change", () => this.#choose(name, select.value));
    row.append(label, select, element("small", {}));
    return row;
  }

  #show(row, { name, description, terms, channels, error }) {
    const select = row.querySelector("select");
    const presets = this.#presets;
    const edit = JSON.stringify((this.#wanted ?? this.state.materials)[name]);
    const preset = Object.keys(presets).find((key) => JSON.stringify(presets[key]) === edit);
    select.value = preset ?? OWN;
    const note = row.querySelector("small");
    const kind = description.type.replaceAll("_", "-");
    const colour = channels === 1 ? "grey" : "three channels";
    const fit = error > 0 ? `fit ${(100 * error).toFixed(0)} % off` : "exact";
    note.textContent = terms === null
      ? kind
      : `${kind} · K = ${terms}, ${colour} · ${fit}`;
    note.title = "K terms of the BRDF, its transport, and the relative RMS error of their sum";
    note.classList.toggle("off", error > OFF);
  }

  #choose(name, preset) {
    const wanted = { ...(this.#wanted ?? this.state.materials) };
    if (preset === OWN) delete wanted[name];
    else wanted[name] = this.#presets[preset];
    this.#ask(wanted);
  }

  async #ask(wanted) {
    this.#end();
    // The scene's own are precomputed by looking at them.
    if (!Object.keys(wanted).length) {
      this.state.setMaterials({});
      return;
    }
    this.#wanted = wanted;
    try {
      this.#job = await this.call(
        `${this.#path}/precompute`,
        post({ method: this.state.method, edits: { materials: wanted } }),
      );
    } catch {
      this.#wanted = null;
      this.refresh();
      return;
    }
    if (this.#wanted !== wanted) return;
    this.#events = new EventSource(`api/jobs/${this.#job.id}/events`);
    this.#events.addEventListener("job", ({ data }) => this.#moved(JSON.parse(data), wanted));
  }

  #moved(job, wanted) {
    if (job.id !== this.#job?.id) return;
    const over = !["queued", "running"].includes(job.status);
    this.follow(over ? null : job);
    if (!over) return;
    this.#events.close();
    this.#job = this.#events = this.#wanted = null;
    if (job.status === "done") this.state.setMaterials(wanted);
    else if (job.problem) this.problem(job.problem);
    this.refresh();
  }

  // Give up what is being made, if anything is.
  #end() {
    this.#events?.close();
    if (this.#job) {
      this.call(`api/jobs/${this.#job.id}`, { method: "DELETE" }).catch(() => {});
      this.follow(null);
    }
    this.#job = this.#events = this.#wanted = null;
  }
}

export function post(body) {
  return {
    method: "POST",
    headers: { "Content-Type": "application/json" },
    body: JSON.stringify(body),
  };
}
