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
from engine.light.table import LightTable
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_local
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import add, dot, scale, sub, vec
from engine.scene.rays import RayTracer

evaluate = brdfs.evaluate
illuminate = lights.illuminate

# Of a light with extent both may hold: HIDDEN | VISIBLE. Hidden too is a light that shines
# elsewhere, or that the surface turns away from as a whole. No surface: neither holds.
HIDDEN, VISIBLE = 1, 2
CHUNK = 32768


def light_points(
    rays: RayTracer,
    at: NDArray[np.int32],
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    geometric: NDArray[np.float32],
    view: NDArray[np.float32],
    model: NDArray[np.int32],
    row: NDArray[np.float32],
    phase: NDArray[np.uint8],
    size: NDArray[np.float32],
    table: LightTable,
    samples: NDArray[np.float64],
    shadows: bool = True,
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """Reflected radiance (n, 3) float32 of one light, and visibility (n,) uint8.

    position (n, 3) are the places to be lit; the rest of what they are says point at[j] of the
    other arrays. The table holds the light alone. samples (groups, k, 2) are places on it: a point
    is lit from the k of the group that its phase picks. Without shadows nothing hides the light.
    """
    n, per_point = len(position), samples.shape[1]
    kind, light, texels = table.kind[0], table.row[0], table.texels
    radiance = np.zeros((n, 3), np.float32)
    visible = np.zeros(n, np.uint8)

    def part(start: int, stop: int) -> None:
        room = (stop - start) * per_point
        value, origin, direction = (np.zeros((room, 3), np.float32) for _ in range(3))
        index = np.zeros(room, np.int32)
        count = _unshadowed(
            start, stop, at, position, normal, geometric, view, model, row, phase, size, kind,
            light, texels, samples, rays.epsilon, value, origin, direction, index, visible,
        )  # fmt: skip
        if shadows:
            blocked = rays.occluded(origin[:count], direction[:count], 1.0)
        else:
            blocked = np.zeros(count, np.bool_)
        _add_visible(index[:count], value, blocked, radiance, visible)

    for_ranges(part, n, grain=CHUNK // per_point)
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
    start, stop, at, position, normal, geometric, view, model, row, phase, size, kind, light,
    texels, samples, epsilon, value, origin, direction, index, visible,
):  # fmt: skip
    groups, per_point = samples.shape[0], samples.shape[1]
    share = 1.0 / per_point
    count = 0
    rows, lamp, texels = borrow(row), borrow(light), borrow(texels)
    for j in range(start, stop):
        i = at[j]
        if model[i] < 0:
            continue
        x, n, g = vec(position, j), vec(normal, i), vec(geometric, i)
        s, t = tangents(n)
        wo = to_local(vec(view, i), s, t, n)
        group, first, wide = phase[i] % groups, count, np.float64(size[i])
        for k in range(per_point):
            u1, u2 = samples[group, k, 0], samples[group, k, 1]
            wx, wy, wz, distance, r, gr, b = illuminate(kind, lamp, texels, x, wide, u1, u2)
            w = (wx, wy, wz)
            cosine = dot(n, w)
            # A light under the flat triangle cannot reach its upper side, whatever the shading
            # normal.
            if cosine <= 0.0 or dot(g, w) <= 0.0 or r + gr + b <= 0.0:
                continue
            f = evaluate(model[i], rows[i], to_local(w, s, t, n), wo)
            if f[0] + f[1] + f[2] <= 0.0:
                continue
            value[count, 0] = f[0] * r * cosine * share
            value[count, 1] = f[1] * gr * cosine * share
            value[count, 2] = f[2] * b * cosine * share
            o, d = shadow_ray(x, g, w, distance, epsilon)
            for c in range(3):
                origin[count, c] = o[c]
                direction[count, c] = d[c]
            index[count] = j
            count += 1
        if count == first:
            visible[j] = HIDDEN
    return count


@njit(cache=True, nogil=True)
def _add_visible(index, value, blocked, radiance, visible):
    for q in range(index.shape[0]):
        j = index[q]
        visible[j] |= HIDDEN if blocked[q] else VISIBLE
        if not blocked[q]:
            for c in range(3):
                radiance[j, c] += value[q, c]


def average(
    pixel: NDArray[np.int32], samples: NDArray[np.float32], image: NDArray[np.float32]
) -> None:
    """Give each pixel (m,) of the image (n, 3) the mean of its k samples (m * k, 3)."""
    for_ranges(_average, len(pixel), pixel, samples, image, grain=1024)


@njit(cache=True, nogil=True)
def _average(start, stop, pixel, samples, image):
    k = samples.shape[0] // pixel.shape[0]
    for j in range(start, stop):
        for c in range(3):
            total = 0.0
            for s in range(j * k, (j + 1) * k):
                total += samples[s, c]
            image[pixel[j], c] = total / k


def light_edges(
    visible: NDArray[np.uint8], skip: NDArray[np.bool_], width: int
) -> NDArray[np.int32]:
    """Pixels (m,) int32 where light ends: HIDDEN and VISIBLE both hold here or one step away.

    visible (n,) uint8 from `light_points`, a step leads to one of four neighbours; pixels of `skip`
    (n,) bool are left out.
    """
    lit = visible.reshape(-1, width)
    near = lit.copy()
    near[:, 1:] |= lit[:, :-1]
    near[:, :-1] |= lit[:, 1:]
    near[1:] |= lit[:-1]
    near[:-1] |= lit[1:]
    return np.flatnonzero((near.ravel() == HIDDEN | VISIBLE) & ~skip).astype(np.int32)


def seen_around(visible: NDArray[np.uint8], width: int, reach: int) -> NDArray[np.uint8]:
    """(n,) uint8: what holds in the square of pixels within `reach` of each, each way.

    visible (n,) uint8 from `light_points`.
    """
    near = visible.reshape(-1, width).copy()
    for _ in range(reach):
        across = near.copy()
        across[:, 1:] |= near[:, :-1]
        across[:, :-1] |= near[:, 1:]
        near = across.copy()
        near[1:] |= across[:-1]
        near[:-1] |= across[1:]
    return near.ravel()


def on_tangent_planes(
    pixel: NDArray[np.int32],
    eye: tuple[float, float, float],
    view: NDArray[np.float32],
    position: NDArray[np.float32],
    geometric: NDArray[np.float32],
    width: int,
    offsets: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Where rays through sub-samples of pixels meet the tangent planes of the pixels' centres.

    pixel (m,); eye, view, position, geometric of all n pixels of a picture `width` wide; offsets
    (k, 2) in pixels. Returns (m * k, 3) float32.
    """
    out = np.zeros((len(pixel) * len(offsets), 3), np.float32)
    args = (pixel, np.asarray(eye, np.float32), view, position, geometric, width, offsets, out)
    for_ranges(_on_planes, len(pixel), *args, grain=1024)
    return out


@njit(cache=True, nogil=True)
def _on_planes(start, stop, pixel, eye, view, position, geometric, width, offsets, out):
    e = vec(eye.reshape(1, 3), 0)
    k = offsets.shape[0]
    for j in range(start, stop):
        i = pixel[j]
        x, g = vec(position, i), vec(geometric, i)
        height = dot(sub(x, e), g)
        for s in range(k):
            ray = neighbour_ray(view, i, width, offsets[s, 0], offsets[s, 1])
            slope = dot(ray, g)
            p = x if slope > -1e-3 else add(e, scale(ray, height / slope))
            for c in range(3):
                out[j * k + s, c] = p[c]


@njit
def neighbour_ray(view, i, width, dx, dy):
    """Direction from the eye through pixel i moved by (dx, dy) pixels, about unit length."""
    n = view.shape[0]
    d = scale(vec(view, i), -1.0)
    if width > 1:
        other, sign = (i + 1, -dx) if (i + 1) % width else (i - 1, dx)
        d = add(d, scale(sub(vec(view, other), vec(view, i)), sign))
    if n > width:
        other, sign = (i + width, -dy) if i + width < n else (i - width, dy)
        d = add(d, scale(sub(vec(view, other), vec(view, i)), sign))
    return d
