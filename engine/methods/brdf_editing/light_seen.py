"""Which parts of lights each view sample sees; `lighting` asks when a light or a gloss is new.

A light with extent is 64 points in a grid, and what a view sample sees of it 64 bits.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.backend.cpu.shading import shadow_ray
from engine.light import table as lights
from engine.light.base import Light
from engine.light.table import LightTable, light_table
from engine.methods.fixed_view.direct import light_samples
from engine.methods.fixed_view.frame_buffer import Points
from engine.numerics.borrow import borrow
from engine.numerics.frames import to_local
from engine.numerics.vec import dot, vec
from engine.scene.rays import RayTracer

illuminate = lights.illuminate
MOST = 64
BATCH = 1024


class Shining(NamedTuple):
    """The lights that are on, as kernels want them.

    kind, row, texels  see `LightTable`
    points             (l,) int32        how many of each light
    place              (l, 64, 2)        where they are
    """

    kind: NDArray[np.int32]
    row: NDArray[np.float32]
    texels: NDArray[np.float32]
    points: NDArray[np.int32]
    place: NDArray[np.float64]


def shining(all_lights: Sequence[Light], most: int = MOST) -> Shining:
    """Those of the lights that are on, with at most so many points each."""
    table: LightTable = light_table(all_lights)
    count = np.zeros(len(table.kind), np.int32)
    place = np.zeros((len(table.kind), MOST, 2))
    for q, light in enumerate(light for light in all_lights if light.enabled):
        samples = light_samples(light, most)[0]
        count[q] = len(samples)
        place[q, : len(samples)] = samples
    return Shining(table.kind, table.row, table.texels, count, place)


@njit(inline="always")
def from_lamp(surface, light, at, lamp, k):
    """(direction, radiance times solid angle) of point k of a light, as seen from a surface."""
    wx, wy, wz, _, red, green, blue = illuminate(
        light.kind[lamp], light.row[lamp], light.texels, vec(surface.position, at),
        np.float64(surface.size[at]), light.place[lamp, k, 0], light.place[lamp, k, 1],
    )  # fmt: skip
    return (wx, wy, wz), (red, green, blue)


@njit
def lamp_rays(surface, lights, seen, at, lamp, parts, frame, rays, came):
    """Fill `rays` with those to the points of a lamp that are seen, came (N, lanes) with light.

    Weights are the cosine over the number of points, and of parts of the pixel. Returns how many.
    """
    bits, points, count = seen[at, lamp], lights.points[lamp], 0
    for k in range(points):
        if (bits >> np.uint64(k)) & np.uint64(1) == 0:
            continue
        w, light = from_lamp(surface, lights, at, lamp, k)
        wi = to_local(w, frame[0], frame[1], frame[2])
        if wi[2] <= 0.0:
            continue
        rays.x[count], rays.y[count], rays.z[count] = wi
        rays.weight[count] = wi[2] / (points * parts)
        came[count] = 0.0
        for c in range(3):
            came[count, c] = light[c]
        count += 1
    return count


def seen_of(rays: RayTracer, points: Points, light: Shining, start: int, stop: int) -> Any:
    """(stop - start, l) uint64: which points of each light those points see, bit by bit."""
    out = np.zeros((stop - start, len(light.kind)), np.uint64)
    for first in range(start, stop, BATCH):
        last = min(first + BATCH, stop)
        room = (last - first) * int(light.points.sum())
        origin, direction = np.zeros((2, room, 3), np.float32)
        whose = np.zeros((room, 3), np.int32)
        count = _aim(
            first, last, points.position, points.normal, points.geometric, points.model,
            points.size, light, rays.epsilon, origin, direction, whose,
        )  # fmt: skip
        hidden = rays.occluded(origin[:count], direction[:count], 1.0)
        _mark(whose[:count], hidden, out[first - start :])
    return out


@njit(cache=True, nogil=True)
def _aim(start, stop, position, normal, geometric, model, size, light, epsilon, origin, direction,
         whose):  # fmt: skip
    light = borrow(light)
    count = 0
    for i in range(start, stop):
        if model[i] < 0:
            continue
        x, n, g = vec(position, i), vec(normal, i), vec(geometric, i)
        for q in range(light.kind.shape[0]):
            row = light.row[q]
            for k in range(light.points[q]):
                wx, wy, wz, distance, red, green, blue = illuminate(
                    light.kind[q], row, light.texels, x, np.float64(size[i]), light.place[q, k, 0],
                    light.place[q, k, 1],
                )  # fmt: skip
                w = (wx, wy, wz)
                if dot(n, w) <= 0.0 or dot(g, w) <= 0.0 or red + green + blue <= 0.0:
                    continue
                o, d = shadow_ray(x, g, w, distance, epsilon)
                for c in range(3):
                    origin[count, c], direction[count, c] = o[c], d[c]
                whose[count, 0], whose[count, 1], whose[count, 2] = i - start, q, k
                count += 1
    return count


@njit(cache=True, nogil=True)
def _mark(whose, hidden, out):
    for r in range(whose.shape[0]):
        if not hidden[r]:
            out[whose[r, 0], whose[r, 1]] |= np.uint64(1) << np.uint64(whose[r, 2])
