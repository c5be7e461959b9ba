// The live socket: edits go out, frames and jobs come in. It is opened again whenever it is lost.

const FIRST_RETRY = 500;
const LAST_RETRY = 5000;
const RARE_RETRY = 30_000; // while frames come by requests
const OPEN_MS = 4000; // a proxy that lets no socket through may just not answer

export class LiveSocket {
  #socket = null;
  #retry = FIRST_RETRY;
  #failures = 0;
  #timer = null;
  #closed = false;

  // handlers: up(), down(failures) where it has failed so often in a row, frame(header, blob),
  // message(message)
  constructor(scene, handlers) {
    this.handlers = handlers;
    this.url = new URL(`api/scenes/${encodeURIComponent(scene)}/live`, location.href);
    this.url.protocol = this.url.protocol === "https:" ? "wss:" : "ws:";
    this.rare = false; // whether to try again but now and then
    this.#open();
  }

  get isOpen() {
    return this.#socket?.readyState === WebSocket.OPEN;
  }

  send(message) {
    if (this.isOpen) this.#socket.send(JSON.stringify(message));
  }

  close() {
    this.#closed = true;
    clearTimeout(this.#timer);
    this.#socket?.close();
  }

  #open() {
    const socket = new WebSocket(this.url);
    socket.binaryType = "arraybuffer";
    // An attempt that takes too long is given up: that counts as two.
    const slow = setTimeout(() => {
      this.#failures += 1;
      socket.close();
      ended({});
    }, OPEN_MS);
    const ended = (event) => {
      clearTimeout(slow);
      socket.onopen = socket.onclose = socket.onmessage = null;
      if (!this.#closed) this.#lost(event);
    };
    socket.onopen = () => {
      clearTimeout(slow);
      this.#retry = FIRST_RETRY;
      this.#failures = 0;
      this.handlers.up();
    };
    socket.onmessage = ({ data }) => {
      if (this.#closed) return;
      if (typeof data === "string") this.handlers.message(JSON.parse(data));
      else this.#frame(data);
    };
    socket.onclose = ended;
    this.#socket = socket;
  }

  #lost({ code }) {
    this.#failures += 1;
    this.handlers.down(this.#failures);
    if (code === 4404) return; // there is no such scene
    this.#timer = setTimeout(() => this.#open(), this.rare ? RARE_RETRY : this.#retry);
    this.#retry = Math.min(LAST_RETRY, 2 * this.#retry);
  }

  #frame(data) {
    const length = new DataView(data).getUint32(0, true);
    const header = JSON.parse(new TextDecoder().decode(new Uint8Array(data, 4, length)));
    const blob = new Blob([new Uint8Array(data, 4 + length)], { type: `image/${header.format}` });
    // The service may go on once the frame was looked at, whatever became of it.
    this.handlers.frame(header, blob).finally(() => this.send({ type: "ack", seq: header.seq }));
  }
}
