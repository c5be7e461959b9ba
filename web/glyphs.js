// What handles look like, by the type of their light.

import { toHex } from "./colour.js";

export const SVG = "http://www.w3.org/2000/svg";
const MARKS = {
  point: "M12 2v-3M12 25v-3M2 12h-3M25 12h-3M5 5 3 3M19 19l2 2M5 19l-2 2M19 5l2-2",
  spot: "M4 16 1 24M20 16l3 8",
  area: "M1 1h22v22H1z",
  disk: "M12 1a11 11 0 0 1 0 22a11 11 0 0 1 0-22",
  sphere: "M12 1a11 11 0 0 1 0 22a11 11 0 0 1 0-22M1 12c6 4 16 4 22 0",
  projector: "M4 16 1 24h22l-3-8M9 24v-6M15 24v-6",
  uberlight: "M4 16 1 24M20 16l3 8M1 24c7 3 15 3 22 0",
  distant: "M4 24v5M12 25v6M20 24v5",
  sun: "M4 24v5M12 25v6M20 24v5M12 2v-4",
};

export function path(d, name) {
  const node = document.createElementNS(SVG, "path");
  node.setAttribute("d", d);
  if (name) node.setAttribute("class", name);
  return node;
}

const SIZE = "M6 6h12v12H6z"; // of what has an extent

export function glyph(light, name, inside, angle) {
  if (!["position", "direction", "target"].includes(name)) return [path(SIZE, "body")];
  const circle = document.createElementNS(SVG, "circle");
  for (const [key, value] of Object.entries({ cx: 12, cy: 12, r: name === "target" ? 8 : 7 })) {
    circle.setAttribute(key, value);
  }
  circle.setAttribute("class", name === "target" ? "mark" : "body");
  const off = name === "target" || !light.enabled;
  circle.setAttribute("fill", off ? "transparent" : toHex(light.intensity));
  if (name === "target") return [circle, path("M12 10v4M10 12h4", "mark")];
  if (!inside) {
    const arrow = path("M22 7l5 5-5 5", "mark");
    arrow.setAttribute("transform", `rotate(${angle} 12 12)`);
    return [circle, arrow];
  }
  return [circle, path(MARKS[light.type] ?? "", "mark")];
}
