// Rows of a panel: a label, a control, a unit.

export function element(tag, properties) {
  return Object.assign(document.createElement(tag), properties);
}

export function field(label, control, unit = "") {
  const row = element("div", { className: "field" });
  const identity = `field-${label.replace(/\W+/g, "-")}`;
  const name = element("label", { textContent: label, htmlFor: identity });
  const input = control.matches("input, select") ? control : control.querySelector("input");
  input.id = identity;
  const cell = element("span", { className: "unit" });
  cell.append(control);
  if (unit) cell.append(element("small", { textContent: unit }));
  row.append(name, cell);
  return row;
}

export const capital = (word) => word[0].toUpperCase() + word.slice(1);
export const words = (name) => capital(name.replace(/_degrees$/, "").replaceAll("_", " "));
export const number = (value) => String(Number(Number(value).toPrecision(4)));
