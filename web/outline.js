// Lines of the selected light over the picture: its axis, its cone, its beam or its frame.

import { project } from "./camera.js";
import { add, cross, length, normalize, scale, sub } from "./vector.js";

const NEAR = 1e-3;
const RING = 48;

// [{d, quiet}] SVG paths in picture coordinates from 0 to 1.
export function outline(light, camera) {
  const lines = [];
  if (light.position && light.target) {
    lines.push({ d: polyline([light.position, light.target], camera), quiet: true });
  }
  const shape = SHAPES[light.type]?.(light, camera);
  if (shape) lines.push({ d: polyline(shape, camera), quiet: false });
  return lines.filter(({ d }) => d);
}

function polyline(points, camera) {
  let d = "";
  for (let i = 1; i < points.length; i += 1) {
    const a = project(camera, points[i - 1]);
    const b = project(camera, points[i]);
    // Segments that reach behind the eye are left out.
    if (a.depth < NEAR || b.depth < NEAR) continue;
    d += `M${a.x.toFixed(5)} ${a.y.toFixed(5)}L${b.x.toFixed(5)} ${b.y.toFixed(5)}`;
  }
  return d;
}

// Two unit vectors across the axis.
export function across(axis, up) {
  let side = cross(up, axis);
  if (length(side) < 1e-6) side = cross([0, 0, 1], axis);
  if (length(side) < 1e-6) side = [1, 0, 0];
  side = normalize(side);
  return [side, cross(axis, side)];
}

// By type, what to draw of a light besides its axis.
const SHAPES = {
  spot: cone,
  area: (light) => rectangle(light.position, axes(light), light.width / 2, light.height / 2),
  disk: (light) => ring(light.position, axes(light), light.radius, light.radius),
  sphere: (light, camera) => {
    const towards = normalize(sub(camera.position, light.position));
    return ring(light.position, across(towards, camera.up), light.radius, light.radius);
  },
  projector,
  uberlight,
};

export const axes = (light) =>
  across(normalize(sub(light.target, light.position)), light.up ?? [0, 1, 0]);

// The rim of the cone at the target.
function cone(light) {
  const degrees = Math.min(80, light.cone_degrees ?? 0);
  const radius = throwOf(light) * Math.tan((degrees * Math.PI) / 180);
  return ring(light.target, axes({ ...light, up: [0, 1, 0] }), radius, radius);
}

// The border of the image at the target; as its proportions are not known here, of its height.
function projector(light) {
  const half = throwOf(light) * Math.tan((Math.min(160, light.fov_y_degrees) * Math.PI) / 360);
  return rectangle(light.target, axes(light), half, half);
}

// The inner shape of the beam at the target.
function uberlight(light) {
  const half = light.parallel ? 0.5 : 0.5 * throwOf(light);
  const [a, b] = [half * light.width, half * light.height];
  if (light.roundness < 0.05) return rectangle(light.target, axes(light), a, b);
  return ring(light.target, axes(light), a, b, light.roundness);
}

export const throwOf = (light) => length(sub(light.target, light.position));

// A superellipse of half axes a and b; roundness 1 is an ellipse.
function ring(centre, [s, t], a, b, roundness = 1) {
  const bent = (v) => Math.sign(v) * Math.abs(v) ** roundness;
  return Array.from({ length: RING + 1 }, (_, i) => {
    const angle = (2 * Math.PI * i) / RING;
    const [x, y] = [a * bent(Math.cos(angle)), b * bent(Math.sin(angle))];
    return add(centre, add(scale(s, x), scale(t, y)));
  });
}

function rectangle(centre, [s, t], a, b) {
  const corner = (i, j) => add(centre, add(scale(s, i * a), scale(t, j * b)));
  return [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1), corner(-1, -1)];
}
