"""The view-dependent vectors h_k of a point that is seen: `glossy_prt` eq. 5, 10, for kernels."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.base import diffuse_colour, specular_colour
from engine.methods.glossy_prt.terms import BOTH_VARY, Terms
from engine.methods.glossy_prt.vertices import frame
from engine.numerics.frames import to_local
from engine.numerics.hemisphere_maps import disk_taps
from engine.numerics.vec import add, cross, dot, normalize, scale, sub, vec
from engine.numerics.wavelet_vectors import before
from engine.scene import surface

LOWEST = 0.02  # cosine of a view below which maps are not looked up: beyond their rim is nothing


class Maps(NamedTuple):
    """View maps and vectors of all materials.

    first     (materials,) int64    row of the first vertex's first vector
    vertex    (materials,) int64    the first vertex
    terms     (materials,) int32    K
    size      (materials,) int32    texels along a view map
    texel     (materials,) int64    its first texel's first term in `h`, in threes
    textured  (materials,) int32    see `Terms`
    h         (numbers,) float32    view maps, material by material, texel by texel, term by term,
                                    the three channels of each
    """

    first: NDArray[np.int64]
    vertex: NDArray[np.int64]
    terms: NDArray[np.int32]
    size: NDArray[np.int32]
    texel: NDArray[np.int64]
    textured: NDArray[np.int32]
    h: NDArray[np.float32]


def stack_maps(terms: list[Terms], count: NDArray[np.integer]) -> Maps:
    """`Maps` of the materials' terms and of how many vertices have each material."""
    views = [t.view.reshape(-1, 3) for t in terms]
    many = np.array([t.count for t in terms], np.int32)

    return Maps(
        first=before(count * many),
        vertex=before(count),
        terms=many,
        size=np.array([t.view.shape[0] for t in terms], np.int32),
        texel=before(np.array([len(v) for v in views])),
        textured=np.array([t.textured for t in terms], np.int32),
        h=np.concatenate(views).ravel(),
    )


@njit
def first_row(maps, vertices, material, vertex):
    """Row of the first vector of a vertex of a material."""
    return maps.first[material] + (vertex - maps.vertex[material]) * maps.terms[material]


@njit
def rows_of(vertices, maps, t, m):
    """1 where one view-dependent vector serves all corners of triangle t of material m, else 3.

    A constant needs no frame; frames that turn by too much to go between are taken one by one.
    """
    return 1 if vertices.smooth[t] or maps.size[m] == 1 else 3


# Inlined by Numba: a call would copy the descriptors of three dozen arrays, which takes longer than
# all the rest.
@njit(inline="always")
def view_vectors(geometry, materials, vertices, maps, t, b1, b2, w, row, out):
    """Fill out (1 or 3, at least 3 K), see `rows_of`: h_k(w) in three channels, term by term.

    What is seen from direction w at (b1, b2) of triangle t is the sum over terms of that times the
    light-dependent vectors between the corners, or of the corners times their barycentrics. row
    (ROW,) is scratch. Returns the number of rows.
    """
    m = geometry.material[t]
    size, first, rows = maps.size[m], maps.texel[m], rows_of(vertices, maps, t, m)
    for r in range(rows):
        h = out[r, : 3 * maps.terms[m]]
        if size == 1:
            for q in range(h.shape[0]):
                h[q] = maps.h[3 * first + q]
        else:
            s, t_, n = _between(vertices, t, b1, b2) if rows == 1 else _own(vertices, t, r)
            x, y, z = to_local(w, s, t_, n)
            if z < LOWEST:
                x, y, z = normalize((x, y, LOWEST))
            taps, (fx, fy) = disk_taps((x, y, z), size)
            _mix(maps.h, first, taps, np.float32(fx), np.float32(fy), h)
    if maps.textured[m]:
        surface.parameters(geometry, materials, t, b1, b2, w, row)
        base, gloss = diffuse_colour(row), specular_colour(row)
        for r in range(rows):
            for c in range(3):
                out[r, c] *= np.float32(base[c])
                if maps.textured[m] == BOTH_VARY:
                    for k in range(1, maps.terms[m]):
                        out[r, 3 * k + c] *= np.float32(gloss[c])
    return rows


@njit(fastmath={"contract", "reassoc"})
def _mix(maps, first, taps, fx, fy, out):
    """Between the four texels of a map of so many numbers each as `out` has."""
    n, one = out.shape[0], np.float32(1)
    a = maps[3 * first + taps[0] * n : 3 * first + (taps[0] + 1) * n]
    b = maps[3 * first + taps[1] * n : 3 * first + (taps[1] + 1) * n]
    c = maps[3 * first + taps[2] * n : 3 * first + (taps[2] + 1) * n]
    d = maps[3 * first + taps[3] * n : 3 * first + (taps[3] + 1) * n]
    p, q, r, s = (one - fx) * (one - fy), fx * (one - fy), (one - fx) * fy, fx * fy
    for k in range(n):
        out[k] = p * a[k] + q * b[k] + r * c[k] + s * d[k]


@njit
def _own(vertices, t, corner):
    return frame(vertices.normal, vertices.tangent, vertices.corners[t, corner])


@njit
def _between(vertices, t, b1, b2):
    """The frame (s, t, n) at barycentrics of a triangle."""
    n, s = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    for corner, weight in enumerate((1.0 - b1 - b2, np.float64(b1), np.float64(b2))):
        v = vertices.corners[t, corner]
        n = add(n, scale(vec(vertices.normal, v), weight))
        s = add(s, scale(vec(vertices.tangent, v), weight))
    n = normalize(n)
    s = normalize(sub(s, scale(n, dot(s, n))))
    return s, cross(n, s), n
