// A new light of a type: in view, as large as the scene asks, as strong as its like there.

import { strength } from "./colour.js";
import { add, mix, scale, sub } from "./vector.js";

// Parts of the scene's diagonal.
const SIZES = { width: 0.08, height: 0.08, radius: 0.05, reference_distance: 0.2 };

// fields are in place of the usual ones; taken are ids that are given away already.
export function newLight(state, type, fields = {}, stem = type, taken = []) {
  const { position, target, up } = state.camera;
  const { diagonal, light_types: types } = state.scene;
  const { properties } = types[type];
  const place = add(mix(position, target, 0.9), scale(up, 0.08 * diagonal));
  const light = {
    id: freeId(state, stem, taken), type, enabled: true, intensity: usualIntensity(state, type),
  };
  if (properties.position) light.position = place;
  if (properties.target) light.target = add(place, [0, -0.2 * diagonal, 1e-3]);
  if (properties.direction) light.direction = sub(target, add(position, up));
  for (const [name, share] of Object.entries(SIZES)) {
    // A beam's width and height are those at one metre, whatever the scene.
    if (properties[name] && (type !== "uberlight" || name === "reference_distance")) {
      light[name] = share * diagonal;
    }
  }
  for (const [name, schema] of Object.entries(properties)) {
    if (!(name in light) && schema.default !== undefined) light[name] = schema.default;
  }
  return { ...light, ...fields };
}

export function freeId(state, stem, taken = [], first = 1) {
  let number = first;
  while (state.light(`${stem}-${number}`) || taken.includes(`${stem}-${number}`)) number += 1;
  return `${stem}-${number}`;
}

function usualIntensity({ scene }, type) {
  const like = scene.lights.filter((light) => light.type === type);
  if (like.length && type !== "uberlight") return like[0].intensity;
  const d = scene.diagonal;
  const sizes = Object.fromEntries(Object.entries(SIZES).map(([name, share]) => [name, share * d]));
  const s = usualReach(scene) / reach({ type, ...sizes }, d);
  return [s, s, s];
}

// The strongest of the scene as a point's W/sr.
export function usualReach({ lights, diagonal: d }) {
  const points = lights.map((light) => strength(light.intensity) * reach(light, d));
  return points.length ? Math.max(...points) || 1 : 0.1 * d * d;
}

// What a light of strength 1 gives straight ahead is what a point of so many W/sr gives: a lamp of A
// square metres is a point of A times its radiance.
export function reach({ type, width, height, radius, reference_distance: distance }, diagonal) {
  switch (type) {
    case "area": return width * height;
    case "disk": case "sphere": return Math.PI * radius ** 2;
    case "distant": case "sun": return 0.2 * diagonal ** 2;
    case "uberlight": return distance ** 2;
    default: return 1;
  }
}
