// Lines of the selected light over the picture: its axis, its cone or its frame.

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
  if (light.type === "spot") lines.push({ d: polyline(cone(light), camera), quiet: false });
  if (light.type === "area") lines.push({ d: polyline(frame(light), camera), quiet: false });
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
function across(axis, up) {
  let side = cross(up, axis);
  if (length(side) < 1e-6) side = cross([0, 0, 1], axis);
  if (length(side) < 1e-6) side = [1, 0, 0];
  side = normalize(side);
  return [side, cross(axis, side)];
}

// The rim of the cone at the target.
function cone(light) {
  const arm = sub(light.target, light.position);
  const [a, b] = across(normalize(arm), [0, 1, 0]);
  const degrees = Math.min(80, light.cone_degrees ?? 0);
  const radius = length(arm) * Math.tan((degrees * Math.PI) / 180);
  return Array.from({ length: RING + 1 }, (_, i) => {
    const t = (2 * Math.PI * i) / RING;
    return add(light.target, add(scale(a, radius * Math.cos(t)), scale(b, radius * Math.sin(t))));
  });
}

function frame(light) {
  const [a, b] = across(normalize(sub(light.target, light.position)), light.up ?? [0, 1, 0]);
  const corner = (i, j) =>
    add(light.position, add(scale(a, (i * light.width) / 2), scale(b, (j * light.height) / 2)));
  return [corner(-1, -1), corner(1, -1), corner(1, 1), corner(-1, 1), corner(-1, -1)];
}
