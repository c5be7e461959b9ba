"""Light that arrives at points straight from one light, with shadows by rays.

The kernels know points and lights as plain arrays; shapes are those of
`engine.methods.fixed_view.frame_buffer.Points`.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdfs
from engine.light import table as lights
from engine.numerics.frames import tangents, to_local
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import add, dot, scale, sub, vec
from engine.scene.rays import RayTracer

evaluate = brdfs.evaluate
illuminate = lights.illuminate

HIDDEN, VISIBLE, DARK = 0, 1, 2  # DARK: the light does not reach the point even without shadows
CHUNK = 32768


def light_points(
    rays: RayTracer,
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    geometric: NDArray[np.float32],
    view: NDArray[np.float32],
    model: NDArray[np.int32],
    row: NDArray[np.float32],
    kind: int,
    light: NDArray[np.float32],
    u: tuple[float, float],
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Reflected radiance (n, 3) float32 without shadows, and visibility (n,) uint8.

    `kind`, `light` are a row of a LightTable, u the sample of a light with extent.
    """
    n = len(model)
    radiance = np.zeros((n, 3), np.float32)
    visible = np.full(n, DARK, np.uint8)

    def part(start: int, stop: int) -> None:
        origin = np.zeros((stop - start, 3), np.float32)
        direction = np.zeros((stop - start, 3), np.float32)
        index = np.zeros(stop - start, np.int32)
        count = _unshadowed(
            start, stop, position, normal, geometric, view, model, row, kind, light, u[0], u[1],
            rays.epsilon, radiance, origin, direction, index,
        )  # fmt: skip
        blocked = rays.occluded(origin[:count], direction[:count], 1.0)
        visible[index[:count]] = ~blocked

    for_ranges(part, n, grain=CHUNK)
    return radiance, visible


@njit
def shadow_ray(x, g, w, distance, epsilon):
    """(origin, direction) of the segment from x, off its surface, almost to the light.

    g is the geometric normal on the lit side, w the unit direction to the light; the direction's
    length makes 1 the end of the segment, `epsilon` short of a light at `distance`.
    """
    o = add(x, scale(g, epsilon))
    if distance > 1e20:
        return o, scale(w, distance)
    end = sub(add(x, scale(w, max(distance - epsilon, 0.0))), o)
    return o, end


@njit(cache=True, nogil=True)
def _unshadowed(
    start, stop, position, normal, geometric, view, model, row, kind, light, u1, u2, epsilon,
    radiance, origin, direction, index,
):  # fmt: skip
    count = 0
    for i in range(start, stop):
        if model[i] < 0:
            continue
        x, n, g = vec(position, i), vec(normal, i), vec(geometric, i)
        wx, wy, wz, distance, r, gr, b = illuminate(kind, light, x, u1, u2)
        w = (wx, wy, wz)
        cosine = dot(n, w)
        # A light under the flat triangle cannot reach its upper side, whatever the shading normal.
        if cosine <= 0.0 or dot(g, w) <= 0.0 or r + gr + b <= 0.0:
            continue
        s, t = tangents(n)
        f = evaluate(model[i], row[i], to_local(w, s, t, n), to_local(vec(view, i), s, t, n))
        radiance[i, 0] = f[0] * r * cosine
        radiance[i, 1] = f[1] * gr * cosine
        radiance[i, 2] = f[2] * b * cosine
        if f[0] + f[1] + f[2] <= 0.0:
            continue
        o, d = shadow_ray(x, g, w, distance, epsilon)
        for k in range(3):
            origin[count, k] = o[k]
            direction[count, k] = d[k]
        index[count] = i
        count += 1
    return count


def soften_edges(
    rays: RayTracer,
    eye: tuple[float, float, float],
    directions: NDArray[np.float32],
    position: NDArray[np.float32],
    geometric: NDArray[np.float32],
    skip: NDArray[np.bool_],
    visible: NDArray[np.uint8],
    kind: int,
    light: NDArray[np.float32],
    u: tuple[float, float],
    width: int,
    sub: NDArray[np.float32],
) -> NDArray[np.float32]:
    """Visibility (n,) float32: pixels at a shadow's edge get a shadow ray for each sub-sample.

    A pixel lies at an edge where one of its eight neighbours has the other visibility. The
    sub-samples, `directions` (n, 3) plus each of `sub` (k, 2) in pixels, lie on the tangent plane of
    the pixel's centre; pixels of `skip` have real ones and are left alone.
    """
    n = len(visible)
    at_edge = np.zeros(n, np.bool_)
    for_ranges(_at_shadow_edge, n, visible, skip, width, at_edge)
    pixel = np.flatnonzero(at_edge).astype(np.int32)
    fraction = (visible == VISIBLE).astype(np.float32)
    m = len(pixel)
    if m == 0:
        return fraction
    origin = np.zeros((len(sub) * m, 3), np.float32)
    direction = np.zeros((len(sub) * m, 3), np.float32)
    for_ranges(
        _edge_rays, m, pixel, directions, position, geometric, np.asarray(eye, np.float32), width,
        sub, kind, light, u[0], u[1], rays.epsilon, origin, direction,
    )  # fmt: skip
    blocked = rays.occluded(origin, direction, 1.0)
    fraction[pixel] = 1.0 - blocked.reshape(m, -1).mean(axis=1, dtype=np.float32)
    return fraction


@njit(cache=True, nogil=True)
def _at_shadow_edge(start, stop, visible, skip, width, at_edge):
    height = visible.shape[0] // width
    for i in range(start, stop):
        if visible[i] == DARK or skip[i]:
            continue
        x, y = i % width, i // width
        for v in range(max(0, y - 1), min(height, y + 2)):
            for h in range(max(0, x - 1), min(width, x + 2)):
                other = visible[v * width + h]
                if other != DARK and other != visible[i]:
                    at_edge[i] = True


@njit(cache=True, nogil=True)
def _edge_rays(
    start, stop, pixel, directions, position, geometric, eye, width, offsets, kind, light, u1, u2,
    epsilon, origin, direction,
):  # fmt: skip
    e = (float(eye[0]), float(eye[1]), float(eye[2]))
    n = directions.shape[0]
    for j in range(start, stop):
        i = pixel[j]
        x, g, d = vec(position, i), vec(geometric, i), vec(directions, i)
        # Differences to neighbouring pixels span the picture around this one.
        right = i + 1 if (i + 1) % width else i - 1
        below = i + width if i + width < n else i - width
        dx = sub(vec(directions, right), d) if width > 1 else (0.0, 0.0, 0.0)
        dy = sub(vec(directions, below), d) if n > width else (0.0, 0.0, 0.0)
        height = dot(sub(x, e), g)
        for k in range(len(offsets)):
            a, b = offsets[k, 0], offsets[k, 1]
            ray = add(d, add(scale(dx, a), scale(dy, b)))
            slope = dot(ray, g)
            p = x if slope > -1e-3 else add(e, scale(ray, height / slope))
            wx, wy, wz, distance, _r, _g, _b = illuminate(kind, light, p, u1, u2)
            o, s = shadow_ray(p, g, (wx, wy, wz), distance, epsilon)
            for c in range(3):
                origin[j * len(offsets) + k, c] = o[c]
                direction[j * len(offsets) + k, c] = s[c]
