// Groups of lights that are placed round what the camera looks at, as large as the scene asks.

import { basis } from "./camera.js";
import { strength } from "./colour.js";
import { newLight, reach, usualReach } from "./new_light.js";
import { add, length, rotate, scale, sub } from "./vector.js";

const RADIANS = Math.PI / 180;
const [WARM, WHITE, COOL] = [[1, 0.83, 0.64], [1, 1, 1], [0.72, 0.84, 1]];

// Each: degrees round the target to the right of the camera and above it, its distance from there in
// steps of the usual one, its part of a key light, its colour, its size in parts of the scene.
const KEY = { stem: "key", type: "area", round: -40, above: 35, far: 1, part: 2, colour: WARM, size: 0.12 };
const FILL = { stem: "fill", type: "area", round: 50, above: 12, far: 1, part: 0.6, colour: COOL, size: 0.25 };
const RIM = { stem: "rim", type: "spot", round: 160, above: 45, far: 0.7, part: 1.6, colour: WHITE };

export const PRESETS = {
  three: { label: "Three-point: key, fill, rim", lights: [KEY, FILL, RIM] },
  rembrandt: {
    label: "Single key, high and to the side",
    lights: [{ ...KEY, type: "spot", round: -50, above: 48, size: undefined }],
  },
  soft: {
    label: "Soft box overhead",
    lights: [{ stem: "overhead", type: "area", round: 0, above: 80, far: 0.8, part: 2.5, colour: WHITE, size: 0.3 }],
  },
  sides: {
    label: "Warm and cool from the sides",
    lights: [
      { ...KEY, stem: "warm", round: -80, above: 15, colour: [1, 0.55, 0.25] },
      { ...KEY, stem: "cool", round: 80, above: 15, colour: [0.3, 0.55, 1] },
    ],
  },
  ring: {
    label: "Ring of eight",
    lights: Array.from({ length: 8 }, (_, k) => (
      { stem: "ring", type: "point", round: 45 * k, above: 40, far: 0.7, part: 0.12, colour: WHITE }
    )),
  },
};

// The lights of a preset; what is there stays.
export function addPreset(state, name) {
  const added = [];
  for (const spec of PRESETS[name].lights) added.push(made(state, spec, added.map(({ id }) => id)));
  state.setLights([...state.lights, ...added], added.map(({ id }) => id));
}

function made(state, { stem, type, round, above, far, part, colour, size }, taken) {
  const { camera, scene } = state;
  const { diagonal } = scene;
  const { right, up, back } = basis(camera);
  const out = rotate(rotate(back, right, -above * RADIANS), up, round * RADIANS);
  // No farther than the camera, which may stand in a room.
  const usual = Math.min(0.45 * diagonal, 0.8 * length(sub(camera.position, camera.target)));
  const distance = far * usual;
  const fields = { position: add(camera.target, scale(out, distance)), target: camera.target };
  if (size) fields.width = fields.height = size * diagonal;
  const { properties } = scene.light_types[type];
  const able = Object.fromEntries(Object.entries(fields).filter(([field]) => properties[field]));
  const light = newLight(state, type, able, stem, taken);
  // As strong, there, as the scene's strongest is from half the scene away.
  const key = usualReach(scene) * (distance / (0.5 * diagonal)) ** 2;
  const s = (part * key) / (reach(light, diagonal) * strength(colour));
  return { ...light, intensity: colour.map((c) => c * s) };
}
