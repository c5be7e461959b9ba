// The live socket: the newest edit goes out, frames come in, stale ones are thrown away.

const FIRST_RETRY = 500;
const LAST_RETRY = 5000;

export class Live {
  #socket = null;
  #retry = FIRST_RETRY;
  #last = null;
  #seq = 0;
  #arrivals = 0;
  #shown = { seq: -1, arrival: -1 };
  #sentAt = new Map();
  #closed = false;

  // handlers: frame(bitmap, header, roundTrip, cause), job(state), problem(problem, seq),
  // connected(boolean)
  constructor(scene, handlers) {
    this.scene = scene;
    this.handlers = handlers;
    this.#open();
  }

  // cause is when the event came that led to this edit.
  send(edit, cause = performance.now()) {
    this.#seq += 1;
    this.#last = { type: "edit", seq: this.#seq, ...edit };
    this.#sentAt.set(this.#seq, { sent: performance.now(), cause });
    this.#transmit(this.#last);
    return this.#seq;
  }

  close() {
    this.#closed = true;
    this.#socket?.close();
  }

  #transmit(message) {
    if (this.#socket?.readyState === WebSocket.OPEN) this.#socket.send(JSON.stringify(message));
  }

  #open() {
    const url = new URL(`api/scenes/${encodeURIComponent(this.scene)}/live`, location.href);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    const socket = new WebSocket(url);
    socket.binaryType = "arraybuffer";
    socket.onopen = () => {
      this.#retry = FIRST_RETRY;
      this.handlers.connected(true);
      if (this.#last) this.#transmit(this.#last);
    };
    socket.onmessage = ({ data }) => {
      if (typeof data === "string") this.#text(JSON.parse(data));
      else this.#frame(data);
    };
    socket.onclose = (event) => {
      if (this.#closed) return;
      this.handlers.connected(false);
      if (event.code === 4404) return;
      setTimeout(() => this.#closed || this.#open(), this.#retry);
      this.#retry = Math.min(LAST_RETRY, 2 * this.#retry);
    };
    this.#socket = socket;
  }

  #text(message) {
    if (this.#closed) return;
    if (message.type === "job") this.handlers.job(message.job);
    if (message.type === "problem") this.handlers.problem(message.problem, message.seq);
  }

  async #frame(data) {
    const arrival = (this.#arrivals += 1);
    const length = new DataView(data).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    header.preview = header.warnings.some(({ code }) => code === "preview_shown");
    const blob = new Blob([new Uint8Array(data, 4 + length)], { type: `image/${header.format}` });
    let bitmap = null;
    try {
      bitmap = await createImageBitmap(blob);
    } finally {
      // The service may go on, whatever became of this frame.
      this.#transmit({ type: "ack", seq: header.seq });
    }
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
