// Choices of which one holds: scenes, methods. Arrows lead from one to the next, as in any radio group;
// what the chosen one is about is told below it, what others are when the pointer rests on them.

import { element } from "./fields.js";

const STEPS = { ArrowDown: 1, ArrowRight: 1, ArrowUp: -1, ArrowLeft: -1 };

// options are [{value, name, about, beside}]; choose(value) hears of another one. What is `beside` one
// stands next to it.
export function drawChoices(box, options, chosen, choose) {
  const held = box.contains(document.activeElement);
  const any = options.some(({ value }) => value === chosen);
  const buttons = options.map(({ value, name, about }, k) => {
    const button = element("button", { type: "button", title: about });
    const is = value === chosen;
    button.setAttribute("role", "radio");
    button.setAttribute("aria-checked", String(is));
    button.tabIndex = is || (!any && k === 0) ? 0 : -1;
    button.dataset.value = value;
    button.append(element("b", { textContent: name }));
    if (is) button.append(element("small", { textContent: about }));
    button.addEventListener("click", () => choose(value));
    button.addEventListener("keydown", (event) => {
      const step = STEPS[event.key];
      if (!step) return;
      event.preventDefault();
      const next = buttons[(k + step + buttons.length) % buttons.length];
      next.focus();
      next.click();
    });
    return button;
  });
  const rows = options.map(({ beside }, k) => {
    if (!beside) return buttons[k];
    const row = element("div", { className: "sent" });
    row.append(buttons[k], beside);
    return row;
  });
  box.replaceChildren(...rows);
  if (held) buttons.find((button) => button.tabIndex === 0)?.focus({ preventScroll: true });
}

// What a person does with each method, and where.
const METHODS = {
  direct_to_indirect: ["Lights", "lamps and environment; the camera stands still", "lights-part"],
  glossy_prt: ["Camera and sky", "the view and the environment; no lamps", "environment-part"],
  brdf_editing: [
    "Materials", "what things are made of, and the lamps; the camera stands still", "editor-part",
  ],
  wavelet_brdf: [
    "Measured", "measured materials, the view, the lamps; no light that bounces", "editor-part",
  ],
};

export function drawMethods(box, { scene, method }, choose) {
  const options = scene.methods.map(({ name, paper }) => {
    const [short, about] = METHODS[name] ?? [name, paper];
    return { value: name, name: short, about };
  });
  drawChoices(box, options, method, (chosen) => {
    choose(chosen);
    document.getElementById(METHODS[chosen]?.[2])?.scrollIntoView({ block: "start" });
  });
  for (const button of box.children) button.dataset.method = button.dataset.value;
}
