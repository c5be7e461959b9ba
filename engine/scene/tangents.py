"""Tangents along the first texture coordinate, for materials that are brushed in a direction.

Where a surface has no texture coordinates, or they lie on one line, the tangent is 0 and the local
frame's own (`engine.numerics.frames.tangents`) is taken at the point: a field that follows the
normal but not the shape. Anisotropic models are even about their axes, so a tangent and its
opposite are the same, and mirrored coordinates that meet at a vertex do not cancel it.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.vec import add, dot, scale, sub, vec


def vertex_tangents(
    positions: NDArray[np.float32],
    triangles: NDArray[np.int32],
    normals: NDArray[np.float32],
    uvs: NDArray[np.float32],
) -> NDArray[np.float32]:
    """(v, 3) float32, unit and perpendicular to the normals, or 0; in world space.

    positions, normals (v, 3), triangles (t, 3), uvs (v, 2), as of `Geometry`.
    """
    sums = np.zeros((len(positions), 3))
    out = np.zeros((len(positions), 3), np.float32)
    _accumulate(positions, triangles, uvs, sums)
    _finish(normals, sums, out)
    return out


@njit
def along_coordinates(positions, uvs, a, b, c):
    """(e1, e2, ∂x/∂u, ∂x/∂v, area) of the triangle a, b, c: its edges from a, the derivatives times
    `area`, and twice its signed area in texture coordinates.
    """
    origin = vec(positions, a)
    e1, e2 = sub(vec(positions, b), origin), sub(vec(positions, c), origin)
    u1, v1 = float(uvs[b, 0] - uvs[a, 0]), float(uvs[b, 1] - uvs[a, 1])
    u2, v2 = float(uvs[c, 0] - uvs[a, 0]), float(uvs[c, 1] - uvs[a, 1])
    along_u = sub(scale(e1, v2), scale(e2, v1))
    along_v = sub(scale(e2, u1), scale(e1, u2))
    return e1, e2, along_u, along_v, u1 * v2 - u2 * v1


@njit(cache=True, nogil=True)
def _accumulate(positions, triangles, uvs, sums):
    """Add ∂x/∂u of every triangle, as long as the triangle is large, to its three vertices."""
    for k in range(triangles.shape[0]):
        a, b, c = triangles[k]
        e1, e2, along, _, area = along_coordinates(positions, uvs, a, b, c)
        u1, v1 = float(uvs[b, 0] - uvs[a, 0]), float(uvs[b, 1] - uvs[a, 1])
        u2, v2 = float(uvs[c, 0] - uvs[a, 0]), float(uvs[c, 1] - uvs[a, 1])
        size = math.sqrt(dot(along, along))
        if abs(area) <= 1e-7 * (u1 * u1 + v1 * v1 + u2 * u2 + v2 * v2) or size == 0.0:
            continue
        n0 = e1[1] * e2[2] - e1[2] * e2[1]
        n1 = e1[2] * e2[0] - e1[0] * e2[2]
        n2 = e1[0] * e2[1] - e1[1] * e2[0]
        along = scale(along, math.sqrt(n0 * n0 + n1 * n1 + n2 * n2) / size)
        for vertex in (a, b, c):
            sign = -1.0 if dot(vec(sums, vertex), along) < 0.0 else 1.0
            for axis in range(3):
                sums[vertex, axis] += sign * along[axis]


@njit(cache=True, nogil=True)
def _finish(normals, sums, out):
    for k in range(out.shape[0]):
        n, t = vec(normals, k), vec(sums, k)
        whole = math.sqrt(dot(t, t))
        t = sub(t, scale(n, dot(n, t)))
        length = math.sqrt(dot(t, t))
        if length > 1e-3 * whole:
            for axis in range(3):
                out[k, axis] = t[axis] / length


@njit
def grain(geometry, triangle, b1, b2, s, t):
    """(cosine, sine) of the angle from s to the tangent at barycentrics (b1, b2), in the plane of
    the unit vectors s, t; (1, 0) where the surface has none.
    """
    a, b, c = geometry.triangles[triangle]
    ta, tb, tc = vec(geometry.tangents, a), vec(geometry.tangents, b), vec(geometry.tangents, c)
    total = scale(ta, 1.0 - b1 - b2)
    for other, weight in ((tb, b1), (tc, b2)):
        total = add(total, scale(other, -weight if dot(total, other) < 0.0 else weight))
    x, y = dot(total, s), dot(total, t)
    length = math.sqrt(x * x + y * y)
    if length < 1e-6:
        return 1.0, 0.0
    return x / length, y / length
