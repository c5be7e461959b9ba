// The service, live: the newest edit goes out, frames come in, stale ones are thrown away. All goes
// over a socket; where a proxy lets none through, by requests, until one opens after all.

import { Polling } from "./polling.js";
import { LiveSocket } from "./socket.js";

const FAILURES = 2; // of the socket in a row, before requests take its place

export class Live {
  #last = null;
  #seq = 0;
  #arrivals = 0;
  #shown = { seq: -1, arrival: -1 };
  #sentAt = new Map();
  #closed = false;

  // handlers: frame(bitmap, header, roundTrip, cause), job(job), problem(problem, seq),
  // connected("socket", "requests" or null)
  constructor(scene, handlers) {
    const told = (name) => (...what) => this.#closed || handlers[name](...what);
    const [job, problem, connected] = ["job", "problem", "connected"].map(told);
    const frame = (header, blob) => this.#frame(header, blob);
    this.handlers = handlers;
    this.requests = new Polling(scene, {
      frame,
      job,
      problem,
      up: () => this.#polled(true, connected),
      down: () => this.#polled(false, connected),
    });
    this.socket = new LiveSocket(scene, {
      frame,
      message: (message) => {
        if (message.type === "job") job(message.job);
        if (message.type === "problem") problem(message.problem, message.seq);
      },
      up: () => {
        this.requests.stop();
        this.socket.rare = false;
        connected("socket");
        if (this.#last) this.socket.send(this.#last);
      },
      down: (failures) => {
        if (this.requests.on) return;
        connected(null);
        if (failures < FAILURES) return;
        this.requests.start();
        if (this.#last) this.requests.ask(this.#last);
      },
    });
  }

  // cause is when the event came that led to this edit.
  send(edit, cause = performance.now()) {
    this.#seq += 1;
    this.#last = { type: "edit", seq: this.#seq, ...edit };
    this.#sentAt.set(this.#seq, { sent: performance.now(), cause });
    if (this.requests.on) this.requests.ask(this.#last);
    else this.socket.send(this.#last);
    return this.#seq;
  }

  close() {
    this.#closed = true;
    this.requests.stop();
    this.socket.close();
  }

  #polled(works, connected) {
    if (!this.requests.on) return;
    this.socket.rare = works;
    connected(works ? "requests" : null);
  }

  async #frame(header, blob) {
    const arrival = (this.#arrivals += 1);
    header.preview = header.warnings.some(({ code }) => code === "preview_shown");
    const bitmap = await createImageBitmap(blob);
    const { seq } = header;
    const stale =
      seq < this.#shown.seq || (seq === this.#shown.seq && arrival < this.#shown.arrival);
    if (!stale && !this.#closed) {
      const times = this.#sentAt.get(seq);
      for (const old of this.#sentAt.keys()) if (old <= seq) this.#sentAt.delete(old);
      this.#shown = { seq, arrival };
      const roundTrip = times ? performance.now() - times.sent : null;
      this.handlers.frame(bitmap, header, roundTrip, times?.cause ?? null);
    }
    bitmap.close();
  }
}
