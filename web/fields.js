// Rows of a panel: a label, a control, a unit. A control of a value that others change too comes as
// {row, show}, and show(now) brings it up to date; show(now, all) where it stands for several things.

import { fromHex, strength, toHex } from "./colour.js";

const WRITTEN = 'input[type="text"], input[type="search"], textarea';
const LETTERS = `${WRITTEN}, input[type="number"], select`;

let fields = 0;

export function element(tag, properties) {
  return Object.assign(document.createElement(tag), properties);
}

export function field(label, control, unit = "") {
  const row = element("div", { className: "field" });
  const identity = `field-${(fields += 1)}`;
  const name = element("label", { textContent: label, htmlFor: identity });
  const input = control.matches("input, select") ? control : control.querySelector("input");
  input.id = identity;
  const cell = element("span", { className: "unit" });
  cell.append(control);
  if (unit) cell.append(element("small", { textContent: unit }));
  row.append(name, cell);
  return row;
}

// Whether several things differ in a value.
export const differ = (all, get) => new Set(all.map((each) => JSON.stringify(get(each)))).size > 1;

// Mark a row whose things differ.
export function mark(row, control, mixed) {
  row.classList.toggle("mixed", mixed);
  if (mixed) control.setAttribute("aria-description", "mixed");
  else control.removeAttribute("aria-description");
}

// The colour of what has a strength too; what is black gets the strength `dark` with its colour.
// change(value, moving) takes what the hand sets.
export function colour(label, { get, change, dark = 0.5, title = "" }) {
  const input = element("input", { type: "color", title });
  let value = null;
  const pick = (moving) => change(fromHex(input.value, strength(value) || dark), moving);
  input.addEventListener("input", () => pick(true));
  input.addEventListener("change", () => pick(false));
  const row = field(label, input);
  const show = (now, all = [now]) => {
    value = get(now);
    if (document.activeElement !== input) input.value = toHex(value);
    mark(row, input, differ(all, (each) => toHex(get(each))));
  };
  return { row, show };
}

// A slider for the hand and a number for what is exact, which may lie beyond the slider's ends: from
// `least` to `most`. The slider may be one of logarithms. change(value, moving, typed) takes it.
export function slider(label, range, unit, how) {
  const { get, change, title = "", toSlider = (x) => x, fromSlider = (x) => x } = how;
  const { least = range.min, most = range.max } = how;
  const hand = element("input", { type: "range", title, ...range });
  const exact = element("input", {
    type: "number", step: "any", className: "exact", title, min: least, max: most,
  });
  exact.setAttribute("aria-label", `${label}, exact`);
  hand.addEventListener("input", () => change(fromSlider(hand.valueAsNumber), true));
  hand.addEventListener("change", () => change(fromSlider(hand.valueAsNumber), false));
  exact.addEventListener("change", () => {
    if (exact.validity.valid && !Number.isNaN(exact.valueAsNumber)) {
      change(exact.valueAsNumber, false, true);
    }
  });
  const both = element("span", { className: "pair" });
  both.append(hand, exact);
  const show = (now, all = [now]) => {
    const mixed = differ(all, get);
    const value = get(now);
    if (document.activeElement !== hand) hand.value = toSlider(value);
    hand.setAttribute("aria-valuetext", mixed ? "mixed" : `${number(value)} ${unit}`);
    showNumber(exact, value, mixed);
  };
  return { row: field(label, both, unit || " "), show };
}

// A number in its input, where the hand is not at it; none where several things differ in it.
export function showNumber(input, value, mixed, text = number(value)) {
  input.placeholder = mixed ? "mixed" : "";
  if (document.activeElement !== input) input.value = mixed ? "" : text;
}

// Some of the options of a select, under a heading.
export function group(label, options) {
  const box = element("optgroup", { label });
  box.append(...options);
  return box;
}

// Whether a key is text for the control that has the focus, and no command.
export const takesText = (node) => Boolean(node.matches?.(WRITTEN));
export const takesLetters = (node) => Boolean(node.matches?.(LETTERS));

export const capital = (word) => word[0].toUpperCase() + word.slice(1);
export const words = (name) => capital(name.replace(/_degrees$/, "").replaceAll("_", " "));
export const number = (value) => String(Number(Number(value).toPrecision(4)));
