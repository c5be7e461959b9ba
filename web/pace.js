// Which frame a change asks for: a machine of three states, without a clock or a page of its own.
//
//   moving   the hand changes something: full frames if they fit BUDGET_MS, else every second pixel
//   resting  it has let go, or stopped for STOP_MS: a full frame at once
//   final    nothing has changed for FINAL_MS: a lossless frame, and nothing more
//
//   from      when                           to        asks for             and then waits
//   any       it changes under the hand      moving    full or half         STOP_MS; for ever if a
//                                                                           full frame is dear
//   any       it changes, the hand let go    resting   full                 FINAL_MS
//   moving    STOP_MS have passed            resting   full                 the rest of FINAL_MS
//   resting   FINAL_MS have passed           final     lossless             for ever

export const STOP_MS = 120;
export const FINAL_MS = 300;
// Of the service. From pointer to pixels it takes 70 more where the browser has the same two cores,
// and that is to be below 100.
export const BUDGET_MS = 25;
const REMEMBERED = 3; // full frames, of which all have to fit

const HALF = { scale: 2, quality: 80 };
const QUICK = { scale: 1, quality: 80 };
const FULL = { scale: 1, quality: 92 };
const LOSSLESS = { scale: 1, format: "png" };

export class Pace {
  state = "final";
  #times = [];

  // Something changed. dear: a full frame starts work that only a hand that lets go asks for.
  // Returns {request, wait}: what to ask for, and the milliseconds until `waited` is due.
  changed(moving, dear = false) {
    if (!moving) return this.#enter("resting", FULL, FINAL_MS);
    const request = this.fits && !dear ? QUICK : HALF;
    return this.#enter("moving", request, dear ? null : STOP_MS);
  }

  // The wait is over, and nothing has changed meanwhile.
  waited() {
    if (this.state === "moving") return this.#enter("resting", FULL, FINAL_MS - STOP_MS);
    return this.#enter("final", LOSSLESS, null);
  }

  // A full frame took so long.
  took(milliseconds) {
    this.#times = [...this.#times.slice(1 - REMEMBERED), milliseconds];
  }

  // Something else is in the hand: how long its frames take is not known.
  forget() {
    this.#times = [];
  }

  // Whether full frames may be expected to fit the budget.
  get fits() {
    return this.#times.length > 0 && Math.max(...this.#times) <= BUDGET_MS;
  }

  #enter(state, request, wait) {
    this.state = state;
    return { request, wait };
  }
}
