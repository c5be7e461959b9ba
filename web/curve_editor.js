// A curve of points under the hand: levels of an even row of nodes, dragged or moved by keys.
// The schema says what their angles are, and how much each counts in the mean.

import { element, number } from "./fields.js";

const [WIDTH, HEIGHT] = [252, 150];
const [LEFT, RIGHT, TOP, BOTTOM] = [26, 240, 8, 132]; // of the plot
const STEP = 0.02; // of its height, by a key; ten times as much with Shift and by Page keys
const ANGLES = [1, 5, 15, 30, 60, 90]; // degrees that are marked
const FAINT = 0.1; // level from where on the scale is of logarithms
const LEAST_TOP = 100;

// change(values, moving) takes the levels; show(values) draws them. `box` is the element.
export function curveEditor(label, schema, change) {
  const { angles_degrees: angles, weights, items } = schema;
  let [values, top, dragged] = [angles.map(() => 0), LEAST_TOP, null];

  const plot = svg("svg", { viewBox: `0 0 ${WIDTH} ${HEIGHT}`, role: "group", "aria-label": label });
  const grid = svg("g", { class: "grid", "aria-hidden": "true" });
  const line = svg("path", { class: "line", "aria-hidden": "true" });
  const points = angles.map((angle, k) => svg("circle", {
    r: 3.5, cx: x(k), role: "slider", tabindex: k ? -1 : 0, "aria-orientation": "vertical",
    "aria-label": `${label} at ${number(angle)}°`, "aria-valuemin": 0,
  }));
  plot.append(grid, line, ...points);
  const told = element("output", { className: "told" });
  const box = element("div", { className: "curve", title: schema.description ?? "" });
  box.append(element("span", { textContent: label }), plot, told);

  function x(node) {
    return LEFT + ((RIGHT - LEFT) * node) / (angles.length - 1);
  }

  // Height of a level between 0 and 1, and the level of a height.
  const full = () => Math.log10(1 + top / FAINT);
  const height = (level) => Math.log10(1 + level / FAINT) / full();
  const level = (h) => FAINT * (10 ** (Math.min(1, Math.max(0, h)) * full()) - 1);
  const y = (h) => BOTTOM - (BOTTOM - TOP) * h;

  function set(k, h, moving) {
    values = values.with(k, Math.min(items.maximum, Number(level(h).toPrecision(4))));
    draw();
    change(values, moving);
  }

  function draw() {
    const at = values.map((value, k) => [x(k), y(height(value))]);
    line.setAttribute("d", `M${at.map((p) => p.join(" ")).join("L")}`);
    points.forEach((point, k) => {
      point.setAttribute("cy", at[k][1]);
      point.setAttribute("aria-valuemax", top);
      point.setAttribute("aria-valuenow", values[k]);
      point.setAttribute("aria-valuetext", `${number(values[k])}`);
    });
    const mean = values.reduce((sum, value, k) => sum + value * weights[k], 0);
    const over = mean > 1.005;
    const times = mean < 100 ? mean.toPrecision(3) : Math.round(mean).toLocaleString("en");
    told.textContent = over ? `${times} times too much` : `covers ${(100 * mean).toFixed(0)} %`;
    told.classList.toggle("over", over);
  }

  function drawGrid() {
    const levels = [0];
    for (let mark = 1; mark <= top; mark *= 10) levels.push(mark);
    const rows = levels.map((mark) => [
      svg("path", { d: `M${LEFT} ${y(height(mark))}H${RIGHT}` }),
      svg("text", { x: LEFT - 4, y: y(height(mark)) + 3, "text-anchor": "end" }, short(mark)),
    ]);
    const columns = ANGLES.map((angle) => [
      svg("path", { d: `M${x(node(angle))} ${TOP}V${BOTTOM}` }),
      svg("text", { x: x(node(angle)), y: BOTTOM + 12, "text-anchor": "middle" }, `${angle}°`),
    ]);
    grid.replaceChildren(...rows.flat(), ...columns.flat());
  }

  // Where an angle lies between the nodes.
  function node(angle) {
    const next = Math.max(1, angles.findIndex((other) => other >= angle - 1e-3));
    return next - 1 + (angle - angles[next - 1]) / (angles[next] - angles[next - 1]);
  }

  // As high as the points want, with room to pull them up.
  function fit() {
    const highest = 10 ** Math.ceil(Math.log10(2 * Math.max(...values, LEAST_TOP / 2)));
    const wanted = Math.min(items.maximum, highest);
    if (wanted === top && grid.childElementCount) return;
    top = wanted;
    drawGrid();
  }

  function focus(k) {
    const next = Math.min(points.length - 1, Math.max(0, k));
    points.forEach((point, i) => point.setAttribute("tabindex", i === next ? 0 : -1));
    points[next].focus();
  }

  // Where a pointer is: the nearest node, the height.
  function place(event) {
    const frame = plot.getBoundingClientRect();
    const [px, py] = [
      ((event.clientX - frame.left) / frame.width) * WIDTH,
      ((event.clientY - frame.top) / frame.height) * HEIGHT,
    ];
    const nearest = Math.round(((px - LEFT) / (RIGHT - LEFT)) * (angles.length - 1));
    const k = Math.min(angles.length - 1, Math.max(0, nearest));
    return [k, (BOTTOM - py) / (BOTTOM - TOP)];
  }

  plot.addEventListener("pointerdown", (event) => {
    const [k, h] = place(event);
    event.preventDefault();
    plot.setPointerCapture(event.pointerId);
    dragged = k;
    focus(k);
    set(k, h, true);
  });
  plot.addEventListener("pointermove", (event) => {
    if (dragged !== null) set(dragged, place(event)[1], true);
  });
  for (const end of ["pointerup", "pointercancel"]) {
    plot.addEventListener(end, () => {
      if (dragged === null) return;
      dragged = null;
      change(values, false);
    });
  }
  points.forEach((point, k) => point.addEventListener("keydown", (event) => {
    const by = { ArrowUp: 1, ArrowDown: -1, PageUp: 10, PageDown: -10 }[event.key];
    const to = { ArrowLeft: k - 1, ArrowRight: k + 1, Home: 0, End: points.length - 1 }[event.key];
    if (by === undefined && to === undefined) return;
    event.preventDefault();
    if (to !== undefined) focus(to);
    else set(k, height(values[k]) + STEP * by * (event.shiftKey ? 10 : 1), false);
  }));

  function show(now) {
    if (dragged !== null) return;
    values = [...now];
    fit();
    draw();
  }

  return { box, show };
}

const short = (level) => (level < 1000 ? `${level}` : `10${"⁰¹²³⁴⁵⁶"[Math.log10(level)]}`);

function svg(tag, attributes, text = "") {
  const node = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.textContent = text;
  return node;
}
