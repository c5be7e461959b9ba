// Linear light RGB of any strength <-> a picked sRGB colour and a strength.

const encode = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);
const decode = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);

// The largest channel; what is left when it is divided out is the colour.
export const strength = (rgb) => Math.max(...rgb);

export function toHex(rgb) {
  const s = strength(rgb);
  const byte = (c) => Math.round(255 * encode(s > 0 ? Math.max(0, c / s) : 1));
  return `#${rgb.map((c) => byte(c).toString(16).padStart(2, "0")).join("")}`;
}

export function fromHex(hex, s) {
  const rgb = [1, 3, 5].map((i) => decode(parseInt(hex.slice(i, i + 2), 16) / 255));
  const top = Math.max(...rgb);
  // Black has no colour; it is taken as white and dimmed by the strength instead.
  return top > 0 ? rgb.map((c) => (c / top) * s) : [s, s, s];
}

export const withStrength = (rgb, s) => fromRatio(rgb, strength(rgb), s);

function fromRatio(rgb, old, s) {
  return old > 0 ? rgb.map((c) => (c / old) * s) : [s, s, s];
}
