// What the person should know: method, time, size, error, warnings, progress, problems.

export const NAMES = {
  direct: "Direct light only",
  direct_to_indirect: "Direct-to-indirect transfer",
  glossy_prt: "Glossy transfer",
  brdf_editing: "Material editing",
  wavelet_brdf: "Measured materials",
};

// What a precompute brings.
const MADE = {
  direct_to_indirect: "Indirect light",
  glossy_prt: "Glossy transport",
  brdf_editing: "Light for materials",
  wavelet_brdf: "Material coding",
};

const CONNECTED = {
  socket: "Connected",
  requests: "Connected, a request per frame",
};

const PHASES = {
  bounce: "bounces between surfaces, step 1 of 2,",
  final: "light from surfaces to the picture, step 2 of 2,",
  links: "what the picture's surfaces see of others",
  codes: "one material after the other,",
  shadows: "which parts of the lamps they see",
  importance: "what lights may do",
  load: "almost done",
};
const PREVIEW = "preview: "; // before those of a preview
// Of those that end in the number of a pass and of a material.
const NUMBERED = { direct: "direct light", bounce: "bounces" };

export class Status {
  #job = null;
  #asked = null;
  #budget = 0;
  #warnings = [];
  #own = null;

  // action(job) is called by the button beside the progress bar.
  constructor(find, action) {
    this.find = find;
    find("progress-action").addEventListener("click", () => action(this.#job));
    const more = find("notes-more");
    more.addEventListener("click", () => {
      const open = more.getAttribute("aria-expanded") !== "true";
      more.setAttribute("aria-expanded", String(open));
      find("notes").hidden = !open;
    });
  }

  // way: "socket", "requests" where something blocks sockets, or null
  connected(way) {
    const dot = this.find("status-connection");
    const text = CONNECTED[way] ?? "Not connected, trying again …";
    if (dot.textContent === text) return;
    dot.className = `dot ${way ? "on" : "off"}`;
    dot.textContent = text;
  }

  frame(header, roundTrip) {
    const { find } = this;
    const drawn = NAMES[header.method] ?? header.method;
    find("status-method").textContent = header.preview ? `${drawn}, preview` : drawn;
    find("status-time").textContent = `${header.timings.total.toFixed(1)} ms`;
    find("status-trip").textContent = roundTrip === null ? "" : `${Math.round(roundTrip)} ms to the picture`;
    find("status-time").title = Object.entries(header.timings)
      .map(([name, ms]) => `${name} ${ms.toFixed(1)} ms`)
      .join("\n");
    const kind = header.format === "png" ? "lossless" : header.scale > 1 ? "while moving" : "full";
    find("status-size").textContent = `${header.width} × ${header.height} ${kind}`;
    find("status-error").textContent =
      header.error === null ? "" : `error about ${(100 * header.error).toFixed(1)} %`;
    this.#warnings = header.warnings;
    this.#notes();
    if (!header.job && !this.#asked) this.job(null);
    find("problem").hidden = true;
  }

  // Errors below it are not worth a word.
  setBudget(error) {
    this.#budget = error;
    this.#notes();
  }

  // What the page itself has to say, or null.
  note(text) {
    this.#own = text;
    this.#notes();
  }

  // The bytes that the method has precomputed; 0 for none.
  bytes(count) {
    this.find("status-bytes").textContent = count ? size(count) : "";
  }

  exposure(words) {
    this.find("status-exposure").textContent = words;
  }

  #notes() {
    const worth = this.#warnings.filter(({ size }) => size === 0 || size >= this.#budget);
    const messages = worth.map(({ message }) => message);
    if (this.#own) messages.unshift(this.#own);
    this.#count(messages);
    const list = this.find("status-warnings");
    messages.forEach((message, i) => {
      const item = list.children[i] ?? list.appendChild(document.createElement("li"));
      if (item.textContent !== message) item.textContent = message;
    });
    while (list.children.length > messages.length) list.lastChild.remove();
  }

  // The first of them in a line of its own, which is always there: nothing moves when it changes.
  #count(messages) {
    const first = this.find("notes-first");
    const text = messages[0] ?? "No warnings";
    if (first.textContent !== text) first.textContent = text;
    first.classList.toggle("none", !messages.length);
    const more = this.find("notes-more");
    more.hidden = !messages.length;
    const words = messages.length === 1 ? "1 warning" : `${messages.length} warnings`;
    if (more.textContent !== words) more.textContent = words;
    if (!messages.length) {
      more.setAttribute("aria-expanded", "false");
      this.find("notes").hidden = true;
    }
  }

  problem(problem) {
    const box = this.find("problem");
    box.textContent = told(problem);
    box.hidden = false;
  }

  // A job that was asked for beside those that frames wait for; null when it is over.
  asked(job) {
    this.#asked = job;
    this.job(job);
  }

  job(job) {
    const { find } = this;
    this.#job = job;
    const over = !job || job.status === "done";
    find("progress").hidden = over;
    if (over) return;
    const light = MADE[job.method] ?? "Light";
    const percent = Math.round(100 * job.fraction);
    const left = job.eta_seconds === null ? "" : `, ${duration(job.eta_seconds)} left`;
    const texts = {
      queued: `${light} is waiting for its turn`,
      running: `Computing ${light.toLowerCase()}: ${phase(job.phase)} ${percent} %${left}`,
      failed: `No ${light.toLowerCase()}: ${job.problem?.detail ?? "the precompute failed"}`,
      cancelled: `${light} was cancelled: ${job.preview ? "a preview of it" : "direct light"} only`,
    };
    const text = find("progress-text");
    if (text.textContent !== texts[job.status]) text.textContent = texts[job.status];
    const bar = find("progress-bar");
    bar.setAttribute("aria-valuenow", percent);
    bar.firstElementChild.style.width = `${percent}%`;
    const ended = job.status === "failed" || job.status === "cancelled";
    find("progress-action").textContent = ended ? "Compute" : "Cancel";
  }
}

// A problem as the service describes it, in a line.
export function told({ file, field, detail }) {
  const where = [file, field].filter(Boolean).join(", ");
  return where ? `${where}: ${detail}` : detail;
}

const size = (bytes) =>
  (bytes < 1e6 ? `${Math.max(1, Math.round(bytes / 1e3))} kB` : `${Number((bytes / 1e6).toPrecision(2))} MB`);

function phase(name) {
  if (name.startsWith(PREVIEW)) return `a preview, ${phase(name.slice(PREVIEW.length))}`;
  const [kind, ...numbers] = name.split("-");
  if (!numbers.length || !NUMBERED[kind]) return PHASES[name] ?? name;
  return `${NUMBERED[kind]} on material ${1 + Number(numbers.at(-1))}`;
}

export function duration(seconds) {
  if (seconds < 90) return `about ${Math.max(1, Math.round(seconds))} s`;
  return `about ${Math.round(seconds / 60)} min`;
}
