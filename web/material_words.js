// Materials in words, in a colour, and as text.

import { strength, toHex } from "./colour.js";
import { capital } from "./fields.js";

export const kind = (type) => (type === "ggx" ? "GGX" : capital(type.replaceAll("_", "-")));

// What became of a material, in a line.
export function madeOf(fit) {
  if (fit?.bytes === undefined || fit.bytes === null) return "";
  if (!fit.bytes) return "exact: drawn by its formula";
  const size = fit.bytes < 1e6 ? `${Math.round(fit.bytes / 1e3)} kB` : `${(fit.bytes / 1e6).toFixed(1)} MB`;
  const tiles = `${fit.terms.toLocaleString("en")} ${fit.terms === 1 ? "tile" : "tiles"}`;
  return `${size} · ${(100 * fit.error).toFixed(1)} % off · ${tiles}`;
}

// A metal has no colour but that of its gloss.
export function swatch({ diffuse = [0.5, 0.5, 0.5], specular = [0, 0, 0] }) {
  return toHex(strength(diffuse) > 0 ? diffuse : specular);
}

// As the materials of a scene and of edits are written, in as many digits as the engine keeps.
export function asText(materials) {
  const short = (key, value) => {
    if (key === "emission" && !strength(value)) return undefined;
    return typeof value === "number" ? Number(value.toPrecision(7)) : value;
  };
  return JSON.stringify(materials, short, 1).replace(/\n\s*/g, " ");
}

export function defaults({ properties }) {
  const pairs = Object.entries(properties).filter(([, schema]) => schema.default !== undefined);
  return Object.fromEntries(pairs.map(([name, schema]) => [name, schema.default]));
}
