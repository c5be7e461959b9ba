// The points of a light that can be dragged: where it is, where it aims, and, of the one in hand, how
// wide its cone or its beam is and how large it is.

import { project } from "./camera.js";
import { within } from "./light_actions.js";
import { across, axes, throwOf } from "./outline.js";
import { add, cross, length, normalize, scale, sub } from "./vector.js";

const RADIANS = Math.PI / 180;
const WIDEST = 80; // degrees of a cone that is drawn

// {name, at, move}: what to change for a new place. One on a ball, for a light at infinity, has `ball`;
// one on a line has `line` {origin, axis, reach} and move(reach) takes metres along it.
export function gripsOf(light, scene, camera, inHand = false) {
  const grips = [];
  if (light.position) {
    grips.push({ name: "position", at: light.position, move: (p) => ({ position: p }) });
  } else if (light.direction) {
    // Held by a point on its way to the middle of the picture.
    const centre = camera.target;
    const radius = 0.3 * scene.diagonal;
    const at = sub(centre, scale(normalize(light.direction), radius));
    const near = project(camera, at).depth < project(camera, centre).depth;
    const move = (p) => ({ direction: sub(centre, p) });
    grips.push({ name: "direction", at, move, ball: { centre, radius, near } });
  }
  if (light.target && inHand) {
    grips.push({ name: "target", at: light.target, move: (p) => ({ target: p }) });
  }
  if (!inHand) return grips;
  const { properties } = scene.light_types[light.type];
  for (const [name, { origin, axis, reach, of }] of Object.entries(SIZES[light.type]?.(light, camera) ?? {})) {
    const move = (metres) => ({ [name]: within(of(Math.max(metres, 1e-6)), properties[name]) });
    // The side that is in the picture, if only one is.
    const ends = [axis, scale(axis, -1)].map((side) => ({ side, at: add(origin, scale(side, reach)) }));
    const { side, at } = ends.find((end) => visible(camera, end.at)) ?? ends[0];
    grips.push({ name, at, move, line: { origin, axis: side, reach } });
  }
  return grips;
}

function visible(camera, point) {
  const { x, y, depth } = project(camera, point);
  return depth > 0 && x >= 0 && x <= 1 && y >= 0 && y <= 1;
}

export const SIZE_NAMES = { cone_degrees: "cone", fov_y_degrees: "image height" };

// By type and field: from where, along which unit axis, how far, and the field's value for that far.
const SIZES = {
  spot: (light, camera) => {
    const far = throwOf(light);
    const reach = far * Math.tan(Math.min(WIDEST, light.cone_degrees) * RADIANS);
    const of = (metres) => Math.min(WIDEST, Math.atan(metres / far) / RADIANS);
    return { cone_degrees: { origin: light.target, axis: seen(ahead(light), light.target, camera), reach, of } };
  },
  area: (light) => sides(light.position, axes(light), light, 1),
  disk: (light, camera) => round(light, seen(ahead(light), light.position, camera)),
  sphere: (light, camera) => round(light, across(ahead({ ...light, target: camera.position }), camera.up)[0]),
  projector: (light) => {
    const far = throwOf(light);
    const reach = far * Math.tan((Math.min(160, light.fov_y_degrees) * RADIANS) / 2);
    const of = (metres) => (2 * Math.atan(metres / far)) / RADIANS;
    return { fov_y_degrees: { origin: light.target, axis: axes(light)[1], reach, of } };
  },
  uberlight: (light) => sides(light.target, axes(light), light, light.parallel ? 1 : throwOf(light)),
};

const ahead = (light) => normalize(sub(light.target, light.position));

// Across an axis, as broad as the camera can see it.
function seen(axis, at, camera) {
  const side = cross(axis, sub(at, camera.position));
  return length(side) > 1e-6 ? normalize(side) : across(axis, camera.up)[0];
}

const round = (light, axis) => ({
  radius: { origin: light.position, axis, reach: light.radius, of: (metres) => metres },
});

// The middle of two sides of a rectangle, its width and height times `far` metres.
function sides(origin, [s, t], { width, height }, far) {
  const of = (metres) => (2 * metres) / far;
  return {
    width: { origin, axis: s, reach: (far * width) / 2, of },
    height: { origin, axis: t, reach: (far * height) / 2, of },
  };
}
