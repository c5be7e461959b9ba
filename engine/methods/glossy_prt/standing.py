"""Pictures for a camera that stands while the light changes: the view's part is found once.

What `corner_views` finds for every ray depends on the camera alone (`glossy_prt` eq. 5). Kept, it
makes a new light a few products a pixel.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light.environment import Environment
from engine.light.environment_samples import seen_radiance
from engine.methods.glossy_prt.vertices import Vertices
from engine.methods.glossy_prt.view import Seen
from engine.methods.glossy_prt.views import Maps, corner_views, first_row
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import scale, vec
from engine.scene.scene import Scene


class Standing(NamedTuple):
    """View-dependent vectors of m rays.

    start  (m + 1,) int64   where those of a ray begin in h: none, one of 3 K numbers for all
                            corners of its triangle, or one for each, times its barycentric
    h      float32
    """

    start: NDArray[np.int64]
    h: NDArray[np.float32]


def stand(scene: Scene, vertices: Vertices, maps: Maps, seen: Seen) -> Standing:
    """The view-dependent vectors of what rays meet."""
    start = np.zeros(len(seen.triangle) + 1, np.int64)
    for_ranges(_count, len(seen.triangle), scene.geometry, vertices, maps, seen, start[1:])
    start = np.cumsum(start)
    h = np.zeros(start[-1], np.float32)
    for_ranges(
        _fill, len(seen.triangle), scene.geometry, scene.material_table, vertices, maps, seen,
        int(maps.terms.max()), start, h, grain=2048,
    )  # fmt: skip
    return Standing(start, h)


def shade_standing(
    scene: Scene,
    vertices: Vertices,
    maps: Maps,
    lit: NDArray[np.float32],
    seen: Seen,
    standing: Standing,
    environment: Environment | None,
) -> NDArray[np.float32]:
    """What `view.shade` gives, (m, 3) float32."""
    out = np.zeros((len(seen.triangle), 3), np.float32)
    for_ranges(
        _shade, len(out), scene.geometry, scene.material_table, vertices, maps, lit, seen,
        *standing, out, grain=2048,
    )  # fmt: skip
    if environment is not None:
        out[seen.beyond] = seen_radiance(environment, seen.places)
    return out


@njit
def _one_frame(vertices, maps, t, m):
    """Whether one vector serves the corners of triangle t of material m, see `corner_views`."""
    return vertices.smooth[t] or maps.size[m] == 1


@njit(cache=True, nogil=True)
def _count(begin, end, geometry, vertices, maps, seen, out):
    for i in range(begin, end):
        t = seen.triangle[i]
        if t >= 0:
            m = geometry.material[t]
            out[i] = 3 * maps.terms[m] * (1 if _one_frame(vertices, maps, t, m) else 3)


@njit(cache=True, nogil=True)
def _fill(begin, end, geometry, materials, vertices, maps, seen, most, start, out):
    geometry, materials, maps = borrow(geometry), borrow(materials), borrow(maps)
    vertices, seen, out = borrow(vertices), borrow(seen), borrow(out)
    own, own_h = np.zeros(materials.row.shape[1], np.float32), np.zeros((3, 3 * most), np.float32)
    row, h = borrow(own), borrow(own_h)
    for i in range(begin, end):
        t = seen.triangle[i]
        if t < 0:
            continue
        w = scale(vec(seen.away, i), -1.0)
        wide = 3 * corner_views(
            geometry, materials, vertices, maps, t, seen.b1[i], seen.b2[i], w, row, h
        )
        into = out[start[i] : start[i + 1]]
        if _one_frame(vertices, maps, t, geometry.material[t]):
            for q in range(wide):
                into[q] = h[0, q] + h[1, q] + h[2, q]
        else:
            for q in range(3 * wide):
                into[q] = h[q // wide, q % wide]


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _shade(begin, end, geometry, materials, vertices, maps, lit, seen, start, h, out):
    geometry, materials, maps = borrow(geometry), borrow(materials), borrow(maps)
    vertices, seen, flat, h = borrow(vertices), borrow(seen), borrow(lit.reshape(-1)), borrow(h)
    for i in range(begin, end):
        t = seen.triangle[i]
        if t < 0:
            continue
        m, n, at = geometry.material[t], start[i + 1] - start[i], start[i]
        wide = 3 * maps.terms[m]
        a = 3 * first_row(maps, vertices, m, vertices.corners[t, 0])
        b = 3 * first_row(maps, vertices, m, vertices.corners[t, 1])
        c = 3 * first_row(maps, vertices, m, vertices.corners[t, 2])
        red = green = blue = np.float32(0)
        if n == wide:
            v, w = seen.b1[i], seen.b2[i]
            u = np.float32(1) - v - w
            for q in range(0, wide, 3):
                red += h[at + q] * (u * flat[a + q] + v * flat[b + q] + w * flat[c + q])
                q1, q2 = q + 1, q + 2
                green += h[at + q1] * (u * flat[a + q1] + v * flat[b + q1] + w * flat[c + q1])
                blue += h[at + q2] * (u * flat[a + q2] + v * flat[b + q2] + w * flat[c + q2])
        else:
            for corner, first in enumerate((a, b, c)):
                mine = at + corner * wide
                for q in range(0, wide, 3):
                    red += h[mine + q] * flat[first + q]
                    green += h[mine + q + 1] * flat[first + q + 1]
                    blue += h[mine + q + 2] * flat[first + q + 2]
        zero = np.float32(0)
        out[i, 0] = max(zero, red) + materials.emission[m, 0]
        out[i, 1] = max(zero, green) + materials.emission[m, 1]
        out[i, 2] = max(zero, blue) + materials.emission[m, 2]
