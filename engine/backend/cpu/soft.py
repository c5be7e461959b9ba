"""Soft shadows on matt surfaces: what a whole light would give, and how much of it is seen.

A matt surface reflects irradiance, for which the lights have formulas; what is left to rays is the
part of it that nothing hides. As a ratio of two means over the same samples that part has no noise
where all of the light is seen, or none (Heitz, Hill, McGuire 2018, *Combining Analytic Direct
Illumination and Stochastic Shadows*). Arrays are those of `shading`, whose pixels `at` and
`position` mean the same.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.backend.cpu.shading import CHUNK, HIDDEN, VISIBLE, shadow_ray
from engine.brdf.base import is_matt
from engine.light import table as lights
from engine.light.table import LightTable
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, vec
from engine.scene.rays import RayTracer

glance = lights.glance
irradiance_by_formula = lights.irradiance


def unshadowed(
    at: NDArray[np.int32],
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    geometric: NDArray[np.float32],
    view: NDArray[np.float32],
    row: NDArray[np.float32],
    size: NDArray[np.float32],
    table: LightTable,
    samples: NDArray[np.float64],
) -> NDArray[np.float32]:
    """Radiance (m, 3) float32 that the matt points `at` (m,) reflect of one light nothing hides.

    samples (k, 2) are places on it, for where it has no formula.
    """
    out = np.zeros((len(at), 3), np.float32)
    for_ranges(
        _reflect, len(at), at, position, normal, geometric, view, row, size, table.kind[0],
        table.row[0], table.texels, samples, out,
    )  # fmt: skip
    return out


@njit(cache=True, nogil=True)
def _reflect(
    start, stop, at, position, normal, geometric, view, row, size, kind, light, texels, samples, out
):
    lamp, texels = borrow(light), borrow(texels)
    for j in range(start, stop):
        i = at[j]
        x, n, g = vec(position, i), vec(normal, i), vec(geometric, i)
        if dot(n, vec(view, i)) <= 0.0:
            continue
        e = irradiance_by_formula(kind, lamp, x, n, g)
        if e[0] < 0.0:
            e = _summed(kind, lamp, texels, x, n, g, np.float64(size[i]), samples)
        for c in range(3):
            out[j, c] = row[i, c] / math.pi * e[c]


@njit
def _summed(kind, lamp, texels, x, n, g, size, samples):
    """`irradiance` from the same samples everywhere, so that neighbours do not differ by chance."""
    r = gr = b = 0.0
    for k in range(samples.shape[0]):
        v = glance(kind, lamp, texels, x, size, samples[k, 0], samples[k, 1])
        w = (v[0], v[1], v[2])
        cosine = dot(n, w) / samples.shape[0]
        if cosine > 0.0 and dot(g, w) > 0.0:
            r, gr, b = r + v[4] * cosine, gr + v[5] * cosine, b + v[6] * cosine
    return (r, gr, b)


def look(
    rays: RayTracer,
    at: NDArray[np.int32],
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    geometric: NDArray[np.float32],
    model: NDArray[np.int32],
    row: NDArray[np.float32],
    phase: NDArray[np.uint8],
    size: NDArray[np.float32],
    table: LightTable,
    samples: NDArray[np.float64],
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """What points `at` (m,) see of one light: means (m, 2) float32, and visibility (m,) uint8.

    The means are those of what arrives, and of what would without shadows, up to a factor. Where
    the horizon of a matt surface cuts a light, only the part above it is looked at: what that gives
    is known, see `unshadowed`.
    """
    n, per_point = len(at), samples.shape[1]
    kind, light, texels = table.kind[0], table.row[0], table.texels
    seen = np.zeros((n, 2), np.float32)
    visible = np.zeros(n, np.uint8)

    def part(start: int, stop: int) -> None:
        room = (stop - start) * per_point
        origin, direction = np.zeros((room, 3), np.float32), np.zeros((room, 3), np.float32)
        weight, index = np.zeros(room, np.float32), np.zeros(room, np.int32)
        count = _aim(
            start, stop, at, position, normal, geometric, model, row, phase, size, kind, light,
            texels, samples, rays.epsilon, weight, origin, direction, index, visible,
        )  # fmt: skip
        blocked = rays.occluded(origin[:count], direction[:count], 1.0)
        _add_up(index[:count], weight, blocked, seen, visible)

    for_ranges(part, n, grain=CHUNK // per_point)
    return seen, visible


@njit(cache=True, nogil=True)
def _aim(
    start, stop, at, position, normal, geometric, model, row, phase, size, kind, light, texels,
    samples, epsilon, weight, origin, direction, index, visible,
):  # fmt: skip
    groups, per_point = samples.shape[0], samples.shape[1]
    count, share = 0, 1.0 / per_point
    lamp, texels, rows = borrow(light), borrow(texels), borrow(row)
    for j in range(start, stop):
        i = at[j]
        if model[i] < 0:
            continue
        x, n, g = vec(position, i), vec(normal, i), vec(geometric, i)
        first, wide = count, np.float64(size[i])
        for turn in range(groups):
            group = (phase[i] + turn) % groups
            for k in range(per_point):
                u1, u2 = samples[group, k, 0], samples[group, k, 1]
                wx, wy, wz, distance, r, gr, b = glance(kind, lamp, texels, x, wide, u1, u2)
                w = (wx, wy, wz)
                value = dot(n, w) * (r + gr + b) * share
                if value <= 0.0 or dot(g, w) <= 0.0:
                    continue
                o, d = shadow_ray(x, g, w, distance, epsilon)
                weight[count], index[count] = value, j
                for c in range(3):
                    origin[count, c], direction[count, c] = o[c], d[c]
                count += 1
            if count > first:
                break
            # All are under the horizon. Is the light? Else others are over it.
            if turn == 0 and (
                not is_matt(rows[i]) or irradiance_by_formula(kind, lamp, x, n, g)[0] == 0.0
            ):
                visible[j] = HIDDEN
                break
            visible[j] = HIDDEN | VISIBLE if turn == groups - 1 else 0
    return count


@njit(cache=True, nogil=True)
def _add_up(index, weight, blocked, seen, visible):
    for q in range(index.shape[0]):
        j = index[q]
        visible[j] |= HIDDEN if blocked[q] else VISIBLE
        seen[j, 1] += weight[q]
        if not blocked[q]:
            seen[j, 0] += weight[q]
