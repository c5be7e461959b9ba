// The list of the lights: which are on, selected, locked; a filter by name; keys. Only the row that
// has the selection is reached by Tab: arrows lead to the others.

import { toHex } from "./colour.js";
import { element } from "./fields.js";
import { path, SVG } from "./glyphs.js";

const MANY = 8; // from so many on there is a filter
const LOCK = "M4 7V5a4 4 0 0 1 8 0v2M3 7h10v7H3z";
const OPEN = "M4 7V5a4 4 0 0 1 7.5-2M3 7h10v7H3z";

export class LightList {
  #rows = new Map(); // by id
  #anchor = null; // from where Shift reaches

  constructor(state, { list, tools, filter, count, several }) {
    Object.assign(this, { state, list, tools, filter, count, several });
    filter.addEventListener("input", () => this.draw());
    several.addEventListener("click", () => {
      several.setAttribute("aria-pressed", String(!this.adding));
    });
    list.addEventListener("keydown", (event) => this.#key(event));
  }

  open() {
    this.#rows.clear();
    this.#anchor = null;
    this.filter.value = "";
    this.several.setAttribute("aria-pressed", "false");
    this.draw();
  }

  // A tap adds to what is selected: fingers hold no keys.
  get adding() {
    return this.several.getAttribute("aria-pressed") === "true";
  }

  // Ids of those that are listed.
  get listed() {
    const text = this.filter.value.trim().toLowerCase();
    const has = ({ id, type }) => `${id} ${type}`.toLowerCase().includes(text);
    return this.state.lights.filter(has).map(({ id }) => id);
  }

  draw() {
    const { state, list } = this;
    const { lights, selection } = state;
    const ids = lights.map(({ id }) => id);
    if (ids.join("\n") !== [...this.#rows.keys()].join("\n") || !list.children.length) this.#build(ids);
    const listed = new Set(this.listed);
    const entry = listed.has(state.selected) ? state.selected : [...listed][0];
    for (const light of lights) this.#show(light, listed.has(light.id), light.id === entry);
    this.tools.hidden = lights.length < 2;
    this.filter.hidden = lights.length < MANY;
    const parts = [];
    if (listed.size < lights.length) parts.push(`${listed.size} of ${lights.length}`);
    if (selection.length > 1) parts.push(`${selection.length} selected`);
    this.count.textContent = parts.join(", ");
    this.#reveal(state.selected);
  }

  #build(ids) {
    this.#rows = new Map(ids.map((id) => [id, this.#row(id)]));
    this.list.replaceChildren(...this.#rows.values());
    if (!ids.length) {
      this.list.append(element("li", { className: "empty", textContent: "No lights yet: add one." }));
    }
  }

  #show(light, listed, entry) {
    const row = this.#rows.get(light.id);
    const selected = this.state.selection.includes(light.id);
    row.hidden = !listed;
    row.classList.toggle("selected", selected);
    const [on, swatch, name, , lock] = row.children;
    on.checked = light.enabled;
    swatch.style.background = light.enabled ? toHex(light.intensity) : "transparent";
    name.setAttribute("aria-pressed", String(selected));
    lock.setAttribute("aria-pressed", String(Boolean(light.locked)));
    const shape = light.locked ? LOCK : OPEN;
    const drawn = lock.querySelector("path");
    if (drawn.getAttribute("d") !== shape) drawn.setAttribute("d", shape);
    for (const control of [on, name, lock]) control.tabIndex = entry ? 0 : -1;
  }

  #row(id) {
    const { state } = this;
    const row = element("li", {});
    row.dataset.light = id;
    const on = element("input", { type: "checkbox", title: `${id} on or off` });
    on.setAttribute("aria-label", `${id} on`);
    on.addEventListener("change", () => state.change(id, { enabled: on.checked }));
    const name = element("button", { type: "button", className: "name", textContent: id, title: id });
    name.addEventListener("click", (event) => {
      if (event.shiftKey) this.#reach(id);
      else this.#select(id, event.ctrlKey || event.metaKey || this.adding);
    });
    const kind = element("span", { className: "kind", textContent: state.light(id).type });
    const lock = element("button", { type: "button", className: "lock", title: `Lock ${id}` });
    lock.setAttribute("aria-label", `Lock ${id}`);
    lock.append(icon());
    lock.addEventListener("click", () => state.change(id, { locked: !state.light(id).locked }));
    row.append(on, element("span", { className: "swatch" }), name, kind, lock);
    return row;
  }

  #select(id, more) {
    this.#anchor = id;
    this.state.select(id, more);
  }

  // All from where the hand was last to this one, which becomes the last.
  #reach(id) {
    const { listed } = this;
    const anchor = listed.includes(this.#anchor) ? this.#anchor : (this.state.selected ?? id);
    const [from, to] = [listed.indexOf(anchor), listed.indexOf(id)];
    const between = from < 0 ? [id] : listed.slice(Math.min(from, to), Math.max(from, to) + 1);
    this.#anchor = from < 0 ? id : anchor;
    this.state.setSelection([...between.filter((other) => other !== id), id]);
  }

  #key(event) {
    const { listed } = this;
    const at = listed.indexOf(event.target.closest("li")?.dataset.light);
    const next = { ArrowUp: at - 1, ArrowDown: at + 1, Home: 0, End: listed.length - 1 }[event.key];
    if (at < 0 || next === undefined || event.ctrlKey || event.metaKey) return;
    event.preventDefault();
    const id = listed[Math.max(0, Math.min(listed.length - 1, next))];
    if (event.shiftKey) this.#reach(id);
    else this.#select(id, false);
    this.#rows.get(id).querySelector(".name").focus({ preventScroll: true });
  }

  // The list scrolls to a row, and nothing else does.
  #reveal(id) {
    const row = this.#rows.get(id);
    if (!row || id === this.shown) return;
    this.shown = id;
    const { list } = this;
    const top = row.offsetTop - list.offsetTop;
    if (top < list.scrollTop) list.scrollTop = top;
    const below = top + row.offsetHeight - list.clientHeight;
    if (below > list.scrollTop) list.scrollTop = below;
  }
}

function icon() {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("viewBox", "0 0 16 16");
  svg.setAttribute("aria-hidden", "true");
  svg.append(path(OPEN));
  return svg;
}
