// The pinhole camera, as the service has it: y up, fov_y_degrees, pixels from the top left.

import { add, cross, dot, length, normalize, rotate, scale, sub } from "./vector.js";

// Right, up and backward: unit length, right-handed.
export function basis(camera) {
  const back = normalize(sub(camera.position, camera.target));
  const right = normalize(cross(camera.up, back));
  return { right, up: cross(back, right), back };
}

const tangent = (camera) => Math.tan((camera.fov_y_degrees * Math.PI) / 360);

// World size of one unit of picture height at a depth.
export const heightAt = (camera, depth) => 2 * depth * tangent(camera);

// {x, y} from 0 at the left and top to 1 at the right and bottom; depth along the view, metres,
// negative behind the camera (x and y are then mirrored).
export function project(camera, point) {
  const { right, up, back } = basis(camera);
  const v = sub(point, camera.position);
  const depth = -dot(v, back);
  const h = heightAt(camera, depth === 0 ? 1e-9 : depth);
  const w = (h * camera.width) / camera.height;
  return { x: 0.5 + dot(v, right) / w, y: 0.5 - dot(v, up) / h, depth };
}

// The world point at picture coordinates and depth.
export function unproject(camera, x, y, depth) {
  const { right, up, back } = basis(camera);
  const h = heightAt(camera, depth);
  const w = (h * camera.width) / camera.height;
  return add(
    add(camera.position, scale(back, -depth)),
    add(scale(right, (x - 0.5) * w), scale(up, (0.5 - y) * h)),
  );
}

// The point of a ball under a place of the picture, on its near or far side; on its rim beside it.
export function onBall(camera, x, y, { centre, radius, near }) {
  const { position } = camera;
  const ray = normalize(sub(unproject(camera, x, y, 1), position));
  const foot = add(position, scale(ray, dot(sub(centre, position), ray)));
  const off = sub(foot, centre);
  const half = radius ** 2 - dot(off, off);
  if (half <= 0) return add(centre, scale(normalize(off), radius));
  return add(foot, scale(ray, (near ? -1 : 1) * Math.sqrt(half)));
}

// How far along a line, from its origin along a unit axis, is nearest to what is under a place of the
// picture; null where the line runs away from the eye.
export function onLine(camera, x, y, { origin, axis }) {
  const ray = normalize(sub(unproject(camera, x, y, 1), camera.position));
  const off = sub(camera.position, origin);
  const along = dot(ray, axis);
  const across = 1 - along ** 2;
  return across < 1e-3 ? null : (dot(off, axis) - along * dot(off, ray)) / across;
}

// Turned about its target: yaw about up, pitch about right; never over the pole.
export function orbit(camera, yaw, pitch) {
  const up = normalize(camera.up);
  const arm = sub(camera.position, camera.target);
  const angle = Math.acos(Math.max(-1, Math.min(1, dot(normalize(arm), up))));
  const limited = Math.max(0.02, Math.min(Math.PI - 0.02, angle - pitch)) - angle;
  const { right } = basis(camera);
  const turned = rotate(rotate(arm, right, limited), up, yaw);
  return { ...camera, position: add(camera.target, turned) };
}

// Nearer to the target (factor below 1) or farther from it.
export function dolly(camera, factor) {
  return {
    ...camera,
    position: add(camera.target, scale(sub(camera.position, camera.target), factor)),
  };
}

// Shifted with its target by fractions of the picture's height at the target.
export function pan(camera, dx, dy) {
  const { right, up } = basis(camera);
  const h = heightAt(camera, length(sub(camera.position, camera.target)));
  const shift = add(scale(right, -dx * h), scale(up, dy * h));
  return { ...camera, position: add(camera.position, shift), target: add(camera.target, shift) };
}
