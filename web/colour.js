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

export const KELVIN = { min: 1667, max: 12000 };

// Linear light RGB of a black body of so many kelvins, its largest channel 1: CIE 1931 chromaticity
// along the Planckian locus by the cubics of Kim et al. 2002.
export function ofTemperature(kelvin) {
  const t = 1000 / kelvin;
  const x = kelvin < 4000
    ? ((-0.2661239 * t - 0.234358) * t + 0.8776956) * t + 0.17991
    : ((-3.0258469 * t + 2.1070379) * t + 0.2226347) * t + 0.24039;
  const [a, b, c, d] = kelvin < 2222
    ? [-1.1063814, -1.3481102, 2.18555832, -0.20219683]
    : kelvin < 4000
      ? [-0.9549476, -1.37418593, 2.09137015, -0.16748867]
      : [3.081758, -5.8733867, 3.75112997, -0.37001483];
  const y = ((a * x + b) * x + c) * x + d;
  const [X, Z] = [x / y, (1 - x - y) / y];
  const rgb = [
    3.2404542 * X - 1.5371385 - 0.4985314 * Z,
    -0.969266 * X + 1.8760108 + 0.041556 * Z,
    0.0556434 * X - 0.2040259 + 1.0572252 * Z,
  ].map((value) => Math.max(0, value));
  return rgb.map((value) => value / Math.max(...rgb));
}

// The temperature whose colour is nearest, null where none is near.
export function temperatureOf(rgb) {
  const s = strength(rgb);
  if (!(s > 0)) return null;
  let [best, least] = [null, 0.06];
  for (let mired = 1e6 / KELVIN.max; mired <= 1e6 / KELVIN.min; mired += 2) {
    const off = Math.hypot(...ofTemperature(1e6 / mired).map((c, i) => c - rgb[i] / s));
    if (off < least) [best, least] = [1e6 / mired, off];
  }
  return best;
}
