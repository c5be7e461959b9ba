// The chart of a method's settings: error over the time of a frame, both logarithmic, as SVG.

const SVG = "http://www.w3.org/2000/svg";
const [WIDE, HIGH] = [192, 150];
const [LEFT, RIGHT, TOP, BOTTOM] = [36, 186, 8, 122];
const ROOM = 1.6; // around the points, as a factor
const DECADE = Math.log(10); // an axis has at least one
const FAR = 5;
const LEAST = 1e-4; // an error of 0 has no logarithm
const NUMBERS = [1, 2, 5];

function node(tag, attributes, ...children) {
  const made = document.createElementNS(SVG, tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}

const errorOf = (error) => 100 * Math.max(error, LEAST);
// A number with its unit, which stay on one line.
export const unit = (value, name) => `${Number(value.toPrecision(2))}\u00a0${name}`;
export const percent = (error) => unit(100 * error, "%");

// The axes reach as far as the points do; what lies beyond them stands at the edge.
export class FrontChart {
  #scales = null;
  #live = null;

  // words(point) is what a point says of itself, in lines.
  constructor(box, words) {
    Object.assign(this, { box, words });
    // It lies over what is below the chart, so that nothing moves away from under the hand.
    this.tip = Object.assign(document.createElement("p"), { className: "tip", hidden: true });
  }

  // Points {cost: {error, frame}, best, ...}, the budget as an error, which point is chosen by it,
  // seconds that the picture took last or null.
  draw(points, budget, chosen, seconds) {
    const times = points.map(({ cost }) => cost.frame);
    // A frame that took far longer than others do, such as the first one, makes no axis longer.
    if (seconds !== null && seconds < FAR * Math.max(...times)) times.push(seconds);
    const x = scale(times.map((time) => 1000 * time), LEFT, RIGHT);
    const y = scale(points.map(({ cost }) => errorOf(cost.error)), BOTTOM, TOP);
    this.#scales = { x, y };
    const svg = node("svg", { viewBox: `0 0 ${WIDE} ${HIGH}`, role: "group" });
    svg.setAttribute("aria-label", "Error over the time of a frame, a point for every setting");
    svg.append(
      axes(x, y),
      node("path", { class: "budget", d: `M${LEFT} ${y.of(errorOf(budget))}H${RIGHT}` }),
      this.#stair(points),
      ...points.map((point, k) => this.#dot(point, k === chosen)),
    );
    this.#live = node("path", { class: "live" });
    this.#live.append(node("title", {}, "The picture as it is now"));
    svg.append(this.#live);
    this.tip.hidden = true;
    this.box.replaceChildren(svg, this.tip);
  }

  // What the picture took last; where no error is known it stands on the upper edge.
  live(seconds, error) {
    if (!this.#live) return;
    const { x, y } = this.#scales;
    const top = error === null ? TOP : y.of(errorOf(error));
    this.#live.setAttribute("d", `M${x.of(1000 * seconds)} ${top - 6}l6 6l-6 6l-6 -6z`);
  }

  // The front: below it and to its left nothing comes.
  #stair(points) {
    const { x, y } = this.#scales;
    const [first, ...rest] = points
      .filter(({ best }) => best)
      .map(({ cost }) => [x.of(1000 * cost.frame), y.of(errorOf(cost.error))])
      .sort((a, b) => a[0] - b[0]);
    const steps = rest.map(([px, py]) => `H${px}V${py}`).join("");
    return node("path", { class: "stair", d: `M${first[0]} ${TOP}V${first[1]}${steps}H${RIGHT}` });
  }

  #dot(point, chosen) {
    const dot = node("circle", {
      cx: this.#scales.x.of(1000 * point.cost.frame),
      cy: this.#scales.y.of(errorOf(point.cost.error)),
      r: chosen ? 5 : 3.5,
      class: ["point", point.best && "best", chosen && "chosen"].filter(Boolean).join(" "),
      tabindex: 0,
      role: "img",
      "aria-label": this.words(point).join(": "),
    });
    const tell = (seen) => {
      this.tip.hidden = !seen;
      this.tip.textContent = this.words(point).join("\n");
    };
    for (const event of ["pointerenter", "focus"]) dot.addEventListener(event, () => tell(true));
    for (const event of ["pointerleave", "blur"]) dot.addEventListener(event, () => tell(false));
    return dot;
  }
}

// Lines, and numbers at 1, 2 and 5 times powers of ten as far as there is room for them.
function axes(x, y) {
  const made = node("g", { class: "axes", "aria-hidden": "true" });
  const title = text("error, %", 0, 0, "middle");
  title.setAttribute("transform", `translate(9 ${(TOP + BOTTOM) / 2}) rotate(-90)`);
  made.append(
    node("path", { d: `M${LEFT} ${TOP}V${BOTTOM}H${RIGHT}` }),
    ...x.ticks(24).map(([number, place]) => text(number, place, BOTTOM + 11, "middle")),
    ...y.ticks(12).map(([number, place]) => text(number, LEFT - 4, place + 3, "end")),
    text("ms a frame", (LEFT + RIGHT) / 2, HIGH - 3, "middle"),
    title,
  );
  return made;
}

function text(content, x, y, anchor) {
  return node("text", { x, y, "text-anchor": anchor }, String(content));
}

// From values to places, and the numbers that an axis shows at least `apart` from each other.
function scale(values, from, to) {
  const [least, most] = [Math.log(Math.min(...values) / ROOM), Math.log(Math.max(...values) * ROOM)];
  const more = Math.max(0, DECADE - (most - least)) / 2;
  const [low, high] = [least - more, most + more];
  const part = (value) => (Math.log(value) - low) / (high - low);
  const of = (value) => from + Math.min(1, Math.max(0, part(value))) * (to - from);
  const ticks = (apart) => {
    const found = [];
    for (let power = -6; power <= 6; power += 1) {
      for (const digit of NUMBERS) {
        const value = Number((digit * 10 ** power).toPrecision(1));
        const inside = Math.log(value) >= low && Math.log(value) <= high;
        if (inside && found.every(([, place]) => Math.abs(place - of(value)) >= apart)) {
          found.push([value, of(value)]);
        }
      }
    }
    return found;
  };
  return { of, ticks };
}
