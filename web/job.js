// A job of the service in a row of its own: how far it is, and a button that stops it.

import { element } from "./fields.js";
import { duration } from "./status.js";

export class JobRow {
  #events = null;
  #job = null;

  // words(job) says what goes on.
  constructor(box, call, words) {
    Object.assign(this, { box, call, words });
    this.text = element("span", {});
    this.text.setAttribute("role", "status");
    this.stop = element("button", { type: "button", textContent: "Cancel" });
    this.stop.addEventListener("click", () => this.cancel());
    this.bar = element("div", { className: "bar" });
    this.bar.setAttribute("role", "progressbar");
    this.bar.setAttribute("aria-label", "Progress");
    this.bar.append(element("i", {}));
    box.append(this.text, this.stop, this.bar);
  }

  get active() {
    return this.#job !== null;
  }

  // Show a job until it ends; ended(job) hears of that.
  follow(job, ended) {
    this.leave();
    this.#show(job);
    this.#events = new EventSource(`api/jobs/${job.id}/events`);
    this.#events.addEventListener("job", ({ data }) => {
      const now = JSON.parse(data);
      this.#show(now);
      if (["queued", "running"].includes(now.status)) return;
      this.leave();
      ended(now);
    });
  }

  #show(job) {
    this.#job = job;
    this.box.hidden = false;
    const percent = Math.round(100 * job.fraction);
    const left = job.eta_seconds === null ? "" : `, ${duration(job.eta_seconds)} left`;
    this.text.textContent =
      job.status === "queued" ? "Waiting for its turn" : `${this.words(job)} ${percent} %${left}`;
    this.bar.setAttribute("aria-valuenow", percent);
    this.bar.firstElementChild.style.width = `${percent}%`;
  }

  // The job goes on, and is not shown any more.
  leave() {
    this.#events?.close();
    this.#events = this.#job = null;
    this.box.hidden = true;
  }

  // Stop the job; `ended` hears of it.
  cancel() {
    if (this.#job) this.call(`api/jobs/${this.#job.id}`, { method: "DELETE" }).catch(() => {});
  }
}
