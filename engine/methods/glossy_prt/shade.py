"""Colours of what a camera sees, from light-dependent vectors of corners: `glossy_prt` §4.3.

What `view_vectors` finds for every ray depends on the camera alone (eq. 5). It is found once for a
camera, so that a new light is a few products a pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light.environment import Environment
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.methods.free_view import Seen
from engine.methods.glossy_prt.vertices import Vertices
from engine.methods.glossy_prt.views import Maps, first_row, rows_of, view_vectors
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import scale, vec
from engine.scene.scene import Scene


class Responses(NamedTuple):
    """View-dependent vectors of m rays, and where those lead that meet nothing.

    start   (m + 1,) int64   where those of a ray begin in h: none where it
                             meets nothing or a back, one of 3 K numbers for all
                             corners of its triangle, or one for each
    h       float32
    beyond  (b,) int64       rays that meet nothing
    places  (b, 2) float32   where on an environment's map those lead, see `places_on_map`
    """

    start: NDArray[np.int64]
    h: NDArray[np.float32]
    beyond: NDArray[np.int64]
    places: NDArray[np.float32]


def respond(scene: Scene, vertices: Vertices, maps: Maps, seen: Seen) -> Responses:
    """What depends on the camera alone."""
    start = np.zeros(len(seen.triangle) + 1, np.int64)
    for_ranges(_count, len(seen.triangle), scene.geometry, vertices, maps, seen, start[1:])
    start = np.cumsum(start)
    h = np.zeros(start[-1], np.float32)
    for_ranges(
        _fill, len(seen.triangle), scene.geometry, scene.material_table, vertices, maps, seen,
        start, h, grain=2048,
    )  # fmt: skip
    beyond = np.flatnonzero(seen.triangle < 0)
    return Responses(start, h, beyond, places_on_map(seen.away[beyond]))


def shade(
    scene: Scene,
    vertices: Vertices,
    maps: Maps,
    lit: NDArray[np.float32],
    seen: Seen,
    responses: Responses,
    environment: Environment | None,
) -> NDArray[np.float32]:
    """(m, 3) float32: radiance that comes along the rays.

    lit (rows, 3) float32 holds the light-dependent vectors, term by term of every vertex.
    """
    out = np.zeros((len(seen.triangle), 3), np.float32)
    for_ranges(
        _shade, len(out), scene.geometry, scene.material_table, vertices, maps, lit, seen,
        responses.start, responses.h, out, grain=2048,
    )  # fmt: skip
    if environment is not None:
        out[responses.beyond] = seen_radiance(environment, responses.places)
    return out


@njit(cache=True, nogil=True)
def _count(begin, end, geometry, vertices, maps, seen, out):
    geometry, vertices = borrow(geometry), borrow(vertices)
    maps, seen = borrow(maps), borrow(seen)
    for i in range(begin, end):
        t = seen.triangle[i]
        if t >= 0 and seen.front[i]:
            m = geometry.material[t]
            out[i] = 3 * maps.terms[m] * rows_of(vertices, maps, t, m)


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _fill(begin, end, geometry, materials, vertices, maps, seen, start, out):
    geometry, materials, maps = borrow(geometry), borrow(materials), borrow(maps)
    vertices, seen, out = borrow(vertices), borrow(seen), borrow(out)
    own = np.zeros(materials.row.shape[1], np.float32)
    row = borrow(own)
    for i in range(begin, end):
        t = seen.triangle[i]
        if t < 0 or not seen.front[i]:
            continue
        wide = 3 * maps.terms[geometry.material[t]]
        w = scale(vec(seen.away, i), -1.0)
        into = out[start[i] : start[i + 1]].reshape(-1, wide)
        view_vectors(geometry, materials, vertices, maps, t, seen.b1[i], seen.b2[i], w, row, into)


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _shade(begin, end, geometry, materials, vertices, maps, lit, seen, start, h, out):
    geometry, materials, maps = borrow(geometry), borrow(materials), borrow(maps)
    vertices, seen, flat, h = borrow(vertices), borrow(seen), borrow(lit.reshape(-1)), borrow(h)
    for i in range(begin, end):
        t = seen.triangle[i]
        if t < 0:
            continue
        m, at = geometry.material[t], start[i]
        wide = 3 * maps.terms[m]
        a = 3 * first_row(maps, vertices, m, vertices.corners[t, 0])
        b = 3 * first_row(maps, vertices, m, vertices.corners[t, 1])
        c = 3 * first_row(maps, vertices, m, vertices.corners[t, 2])
        v, w = seen.b1[i], seen.b2[i]
        u = np.float32(1) - v - w
        red = green = blue = np.float32(0)
        rows = (start[i + 1] - at) // wide
        if rows == 1:
            for q in range(0, wide, 3):
                red += h[at + q] * (u * flat[a + q] + v * flat[b + q] + w * flat[c + q])
                q1, q2 = q + 1, q + 2
                green += h[at + q1] * (u * flat[a + q1] + v * flat[b + q1] + w * flat[c + q1])
                blue += h[at + q2] * (u * flat[a + q2] + v * flat[b + q2] + w * flat[c + q2])
        elif rows == 3:
            for weight, mine, first in ((u, at, a), (v, at + wide, b), (w, at + 2 * wide, c)):
                for q in range(0, wide, 3):
                    red += weight * h[mine + q] * flat[first + q]
                    green += weight * h[mine + q + 1] * flat[first + q + 1]
                    blue += weight * h[mine + q + 2] * flat[first + q + 2]
        zero = np.float32(0)
        out[i, 0] = max(zero, red) + materials.emission[m, 0]
        out[i, 1] = max(zero, green) + materials.emission[m, 1]
        out[i, 2] = max(zero, blue) + materials.emission[m, 2]
