// Where no socket can be opened: a request per frame, the newest edit next, no more than two under
// way; and a look at the job that the view waits for, now and then.

const AT_ONCE = 2;
const RETRY = 1000;
const JOB_EVERY = 500;

export class Polling {
  #waiting = null;
  #underWay = 0;
  #timer = null;
  #job = null; // id of the one that the view waits for
  #jobTimer = null;
  #last = null;
  #asked = 0;
  #arrived = 0; // number of the newest request whose frame is there

  // handlers: up(), down(), frame(header, blob), job(job), problem(problem, seq)
  constructor(scene, handlers) {
    this.path = `api/scenes/${encodeURIComponent(scene)}/frame`;
    this.handlers = handlers;
    this.on = false;
  }

  start() {
    this.on = true;
  }

  // What is under way still arrives.
  stop() {
    this.on = false;
    this.#waiting = this.#job = null;
    clearTimeout(this.#timer);
    clearTimeout(this.#jobTimer);
    this.#timer = this.#jobTimer = null;
  }

  // An edit as the live socket takes it; it replaces one that waits.
  ask(edit) {
    this.#waiting = this.#last = edit;
    this.#next();
  }

  #next() {
    if (!this.on || this.#waiting === null || this.#timer !== null) return;
    if (this.#underWay >= AT_ONCE) return;
    const edit = this.#waiting;
    this.#waiting = null;
    this.#underWay += 1;
    this.#request(edit).finally(() => {
      this.#underWay -= 1;
      this.#next();
    });
  }

  async #request(edit) {
    const number = (this.#asked += 1);
    let response = null;
    let body = null;
    try {
      response = await this.#fetch(edit);
      body = await (response.ok ? response.blob() : response.json());
    } catch (error) {
      // Nobody answers, or a proxy does in the service's place.
      if (!(error instanceof TypeError || error instanceof SyntaxError)) throw error;
      this.handlers.down();
      this.#again(edit, RETRY);
      return;
    }
    this.handlers.up();
    if (response.ok) {
      await this.#took(JSON.parse(response.headers.get("Relight-Frame")), body, edit, number);
    } else if (response.status === 429 || response.status === 503) {
      this.#again(edit, 1000 * (Number(response.headers.get("Retry-After")) || 1));
    } else {
      this.handlers.problem(body, edit.seq);
    }
  }

  #took(header, blob, { seq, scale }, number) {
    if (number < this.#arrived) return null;
    this.#arrived = number;
    if (this.on && scale === 1) this.#follow(header.job);
    // A small frame waits for nothing, yet the view does.
    return this.handlers.frame({ ...header, seq, job: header.job ?? this.#job }, blob);
  }

  #fetch({ edits, exposure, scale, format, quality, method, settings }) {
    const query = new URLSearchParams({ exposure, scale, method, settings: JSON.stringify(settings) });
    if (quality !== undefined) query.set("quality", quality);
    return fetch(`${this.path}?${query}`, {
      method: "POST",
      body: JSON.stringify(edits),
      headers: { "Content-Type": "application/json", Accept: `image/${format}` },
    });
  }

  // Ask again later, for what is newest by then.
  #again(edit, delay) {
    if (!this.on) return;
    this.#waiting ??= edit;
    this.#timer ??= setTimeout(() => {
      this.#timer = null;
      this.#next();
    }, delay);
  }

  #follow(id) {
    if (id === this.#job) return;
    this.#job = id;
    clearTimeout(this.#jobTimer);
    if (id !== null) this.#look();
  }

  async #look() {
    const id = this.#job;
    let job = null;
    try {
      const response = await fetch(`api/jobs/${encodeURIComponent(id)}`);
      if (response.ok) job = await response.json();
    } catch (error) {
      if (!(error instanceof TypeError)) throw error;
    }
    if (id !== this.#job) return;
    if (job !== null) this.handlers.job(job);
    if (job === null || ["queued", "running"].includes(job.status)) {
      this.#jobTimer = setTimeout(() => this.#look(), JOB_EVERY);
    } else if (job.status === "done") {
      this.#job = null;
      this.ask(this.#last);
    }
  }
}
