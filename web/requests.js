// Asks for frames: at the pace of `Pace`, and no more than one per animation frame.

import { Pace } from "./pace.js";

export class Requests {
  #pace = new Pace();
  #due = null;
  #timer = null;
  #edited = "";
  #final = null;

  // send({exposure, edits, scale, format, quality}, cause) hands the request on.
  constructor(state, send) {
    this.state = state;
    this.send = send;
  }

  // Something changed. While a camera moves that transport is made for only small frames are asked
  // for: a full one starts a precompute for its view.
  changed(moving, camera = false) {
    this.#final = null;
    if (this.state.edited !== this.#edited) this.#pace.forget();
    this.#edited = this.state.edited;
    const { request, wait } = this.#pace.changed(moving, camera);
    this.#ask(request, window.event?.timeStamp);
    this.#wait(wait);
  }

  // How long the service took for a frame, in milliseconds.
  took(header) {
    if (header.scale === 1 && header.format === "jpeg") this.#pace.took(header.timings.total);
  }

  // Whether this is the lossless frame of the last change: nothing more will be asked for.
  isFinal(header) {
    return header.seq === this.#final;
  }

  #wait(milliseconds) {
    clearTimeout(this.#timer);
    if (milliseconds === null) return;
    this.#timer = setTimeout(() => {
      const { request, wait } = this.#pace.waited();
      this.#ask(request);
      this.#wait(wait);
    }, milliseconds);
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
