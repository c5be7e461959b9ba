// Which frame to ask for: small ones while the hand moves, the full one when it stops, a lossless
// one when it rests.

const STOP_MS = 120; // the hand is down but has stopped
const REST_MS = 300; // nothing has changed for so long: lossless
const QUICK_MS = 20; // full frames this quick need no smaller ones

export class Requests {
  #due = null;
  #timers = [];
  #fullTime = Infinity;
  #edited = "";
  #final = null;

  // send({exposure, edits, scale, format, quality}, cause) hands the request on.
  constructor(state, send) {
    this.state = state;
    this.send = send;
  }

  // Something changed. While the camera moves only small frames are asked for: a full one starts
  // a precompute for its view.
  changed(moving, camera = false) {
    for (const timer of this.#timers) clearTimeout(timer);
    this.#timers = [];
    this.#final = null;
    // How long something else in the hand takes is not known.
    if (this.state.edited !== this.#edited) this.#fullTime = Infinity;
    this.#edited = this.state.edited;
    const cause = window.event?.timeStamp ?? performance.now();
    if (moving) {
      this.#ask({ scale: this.#fullTime < QUICK_MS && !camera ? 1 : 2, quality: 80 }, cause);
      if (!camera) this.#later(STOP_MS, { scale: 1, quality: 92 });
    } else {
      this.#ask({ scale: 1, quality: 92 }, cause);
    }
    if (!moving || !camera) this.#later(REST_MS, { scale: 1, format: "png" });
  }

  // How long the service took for a frame, in milliseconds.
  took(header) {
    if (header.scale === 1 && header.format === "jpeg") this.#fullTime = header.timings.total;
  }

  // Whether this is the lossless frame of the last change: nothing more will be asked for.
  isFinal(header) {
    return header.seq === this.#final;
  }

  #later(delay, request) {
    this.#timers.push(setTimeout(() => this.#ask(request), delay));
  }

  // At most one request per animation frame; the newest counts.
  #ask(request, cause = performance.now()) {
    const waiting = this.#due !== null;
    // The oldest cause stays: its pixels are what somebody waits for.
    this.#due = { request, cause: waiting ? this.#due.cause : cause };
    if (waiting) return;
    requestAnimationFrame(() => {
      const { request: newest, cause: oldest } = this.#due;
      this.#due = null;
      const { exposure, method, settings } = this.state;
      const edit = { edits: this.state.asked(), exposure, method, settings, format: "jpeg", ...newest };
      const seq = this.send(edit, oldest);
      if (edit.format === "png") this.#final = seq;
    });
  }
}
