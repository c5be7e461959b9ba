// What more or less error would cost: the chart of the method's settings, an error budget, and the
// cheapest settings that hold it.

import { capital } from "./fields.js";
import { FrontChart, percent, unit } from "./front_chart.js";
import { JobRow } from "./job.js";
import { post } from "./materials.js";

const FIRST = 0.01; // budget
const [LEAST, MOST] = [0.005, 0.5];
const HARDLY = 1.25; // so much longer is a frame when one hardly notices
const KINDS = {
  lights: "moved lights", environment: "turned surroundings", camera: "new views",
  materials: "new materials",
};

export class Front {
  #chart = null; // as the service tells it
  #live = null; // seconds of the last frame
  #asked = 0;

  // call asks the service; budget(error) hears of a new one, used() of settings that frames have now.
  constructor(state, find, { call, budget, used }) {
    Object.assign(this, {
      state, call, used, changed: budget, chart: find("front-chart"), told: find("front-told"),
      measure: find("front-measure"), budget: find("budget"), budgetValue: find("budget-value"),
      budgetTold: find("budget-told"), use: find("budget-use"),
    });
    this.drawing = new FrontChart(this.chart, (point) => this.#words(point));
    this.measuring = new JobRow(find("front-measuring"), call, ({ phase }) =>
      phase === "settings" ? "Trying settings:" : "Rendering references:");
    this.using = new JobRow(find("budget-using"), call, () => "Computing:");
    Object.assign(this.budget, { min: Math.log(LEAST), max: Math.log(MOST), step: 0.01, value: Math.log(FIRST) });
    this.budget.addEventListener("input", () => this.#draw());
    this.measure.addEventListener("click", () => this.#measure());
    this.use.addEventListener("click", () => this.#use());
    this.#draw();
  }

  get #budget() {
    return Math.exp(this.budget.valueAsNumber);
  }

  get #path() {
    return `api/scenes/${encodeURIComponent(this.state.scene.name)}`;
  }

  // Another scene or method: what is made for the old one is given up, what is measured goes on.
  open() {
    this.using.cancel();
    this.using.leave();
    this.measuring.leave();
    this.#chart = this.#live = null;
    this.#draw();
    this.#fetch();
  }

  // A frame has come.
  took({ method, scale, timings }) {
    if (method !== this.state.method || scale !== 1) return;
    this.#live = timings.relight / 1000;
    this.#showLive();
  }

  async #fetch() {
    const asked = (this.#asked += 1);
    const method = encodeURIComponent(this.state.method);
    const chart = await this.call(`${this.#path}/chart?method=${method}`).catch(() => null);
    if (asked !== this.#asked) return;
    this.#chart = chart;
    if (chart?.job) this.#follow(chart.job);
    this.#draw();
  }

  async #measure() {
    const asked = this.#asked;
    const method = encodeURIComponent(this.state.method);
    const job = await this.call(`${this.#path}/chart?method=${method}`, { method: "POST" });
    if (asked !== this.#asked) return;
    this.#follow(job);
    this.#draw();
  }

  #follow(job) {
    this.measuring.follow(job, ({ problem }) => this.#ended(problem));
  }

  async #ended(problem) {
    await this.#fetch();
    if (problem) this.told.textContent = problem.detail;
  }

  // The quickest point that holds the budget; of those that are hardly slower, the one that is
  // precomputed first. Where none holds, the most exact one.
  get #chosen() {
    const { points } = this.#chart;
    const holding = points.filter(({ cost }) => cost.error <= this.#budget);
    const least = (among, name) => among.reduce((a, b) => (b.cost[name] < a.cost[name] ? b : a));
    if (!holding.length) return least(points, "error");
    const { frame } = least(holding, "frame").cost;
    return least(holding.filter(({ cost }) => cost.frame <= HARDLY * frame), "precompute");
  }

  async #use() {
    const { state } = this;
    const { camera, materials } = state.edits();
    const edits = {};
    if (camera) edits.camera = camera;
    if (materials && !state.takes("materials")) edits.materials = materials;
    const { settings } = this.#chosen;
    const asked = this.#asked;
    const job = await this.call(`${this.#path}/precompute`, post({ method: state.method, settings, edits }));
    if (asked !== this.#asked) return;
    this.using.follow(job, ({ status, problem }) => {
      if (status === "done") this.used();
      this.#ended(problem);
    });
    this.#draw();
  }

  #draw() {
    const { budgetTold, use } = this;
    const budget = this.#budget;
    this.budgetValue.textContent = percent(budget);
    this.budget.setAttribute("aria-valuetext", percent(budget));
    this.changed(budget);
    const points = this.#chart?.points ?? [];
    const measured = points.length > 0;
    const able = Boolean(this.#chart?.kinds.length);
    this.chart.hidden = use.hidden = budgetTold.hidden = !measured;
    this.measure.hidden = measured || !able || this.measuring.active;
    this.#tell();
    if (!measured) return;
    const chosen = this.#chosen;
    const k = points.indexOf(chosen);
    this.drawing.draw(points, budget, k, this.#live);
    this.#showLive();
    const holds = chosen.cost.error <= budget;
    budgetTold.textContent = `${holds ? "" : `Nothing holds ${percent(budget)}. The best is `}${priced(chosen)}`;
    use.textContent = k === this.#chart.current ? "In use" : "Use it";
    use.disabled = k === this.#chart.current || this.using.active;
  }

  #showLive() {
    const current = this.#chart?.points[this.#chart.current];
    if (this.#live !== null) this.drawing.live(this.#live, current?.cost.error ?? null);
  }

  // A point in lines: its name, its cost, its settings that are not those of all points.
  #words(point) {
    const varied = Object.entries(point.settings).filter(([name, value]) =>
      this.#chart.points.some(({ settings }) => settings[name] !== value));
    const settings = varied.map(([name, value]) => `${name.replaceAll("_", " ")} ${value}`);
    return [capital(point.label), priced(point), settings.join(", ")];
  }

  // What the chart shows, or why there is none.
  #tell() {
    const { told } = this;
    const chart = this.#chart;
    if (!chart) told.textContent = "";
    else if (!chart.kinds.length) told.textContent = "Nothing in this scene is for this method to edit.";
    else if (chart.points.length) {
      told.textContent = `Judged by ${chart.kinds.map((kind) => KINDS[kind]).join(", ")}. Diamond: the picture as it is now.`;
    } else {
      told.textContent = "What would less error cost here, or more gain? To try it takes a minute or so.";
    }
  }
}

function priced({ cost: { error, frame, bytes, precompute } }) {
  const known = [percent(error), unit(1000 * frame, "ms"), unit(bytes / 1e6, "MB"), unit(precompute, "s")];
  return `${known.join(", ")} of precompute`;
}
