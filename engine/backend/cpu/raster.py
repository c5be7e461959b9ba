"""Which triangle each pixel shows, by rasterising: for cameras that move from frame to frame.

Two to three times as fast as a ray for each pixel where triangles are small. It finds what rays
through the same points would, but for ties within rounding.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.parallel import for_ranges, thread_count
from engine.numerics.vec import cross, dot, scale, sub, vec

# Part of a triangle by which its edges are widened, so that no crack is left between two.
ON_EDGE = 1e-6


def visible_triangles(
    positions: NDArray[np.float32],
    triangles: NDArray[np.int32],
    eye: NDArray[np.float64],
    to_pixels: NDArray[np.float64],
    near: float,
    shape: tuple[int, int],
) -> NDArray[np.int32] | None:
    """(height · width,) int32: the nearest triangle at each pixel, -1 for none.

    positions (v, 3), triangles (t, 3), shape (height, width). to_pixels (3, 3) takes a direction
    from the eye to (x d, y d, d): column x, row y, of pixels whose centres are at whole numbers,
    and depth d in metres. None where a triangle reaches nearer than `near`: rays can tell then.
    """
    at = np.zeros((len(positions), 3), np.float32)
    for_ranges(_project, len(at), positions, eye, to_pixels, at)
    height, width = shape
    ids, depth = np.full(height * width, -1, np.int32), np.zeros(height * width, np.float32)
    crossed = np.zeros(height, np.bool_)
    # A band of rows each; every band goes through all triangles.
    rows = max(1, height // thread_count())
    for_ranges(_draw, height, at, triangles, 1 / near, width, ids, depth, crossed, grain=rows)
    return None if crossed.any() else ids


@njit(cache=True, nogil=True)
def _project(start, stop, positions, eye, to_pixels, out):
    """(x, y, 1 / d) of the vertices; 1 / d is not above 0 behind the eye."""
    e = (eye[0], eye[1], eye[2])
    for i in range(start, stop):
        v = sub(vec(positions, i), e)
        d = dot(v, vec(to_pixels, 2))
        inverse = 1.0 / d if d != 0.0 else np.inf
        out[i, 0] = dot(v, vec(to_pixels, 0)) * inverse
        out[i, 1] = dot(v, vec(to_pixels, 1)) * inverse
        out[i, 2] = inverse


@njit(cache=True, nogil=True)
def _draw(top, end, at, triangles, nearest, width, ids, depth, crossed):
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t]
        za, zb, zc = at[a, 2], at[b, 2], at[c, 2]
        behind = (za <= 0.0) + (zb <= 0.0) + (zc <= 0.0)
        if behind == 3:
            continue
        if behind > 0 or max(za, zb, zc) > nearest:
            crossed[top] = True
            return
        xa, ya, xb, yb, xc, yc = at[a, 0], at[a, 1], at[b, 0], at[b, 1], at[c, 0], at[c, 1]
        low, high = max(0.0 + top, min(ya, yb, yc)), min(end - 1.0, max(ya, yb, yc))
        left, right = max(0.0, min(xa, xb, xc)), min(width - 1.0, max(xa, xb, xc))
        if low > high or left > right:
            continue
        area = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
        if area == 0.0:
            continue
        unit = 1.0 / area
        # Barycentrics of b and c are linear over the picture, as 1 / d is.
        bx, by = (yc - ya) * unit, (xa - xc) * unit
        cx, cy = (ya - yb) * unit, (xb - xa) * unit
        for y in range(int(np.ceil(low)), int(high) + 1):
            for x in range(int(np.ceil(left)), int(right) + 1):
                b1 = (x - xa) * bx + (y - ya) * by
                b2 = (x - xa) * cx + (y - ya) * cy
                if b1 < -ON_EDGE or b2 < -ON_EDGE or b1 + b2 > 1.0 + ON_EDGE:
                    continue
                z = np.float32(za + b1 * (zb - za) + b2 * (zc - za))
                i = y * width + x
                if z > depth[i]:
                    depth[i], ids[i] = z, t


@njit
def on_triangle(positions, triangles, t, eye, away):
    """(b1, b2, distance) where the ray from the eye along `away` meets the plane of triangle t."""
    a, b, c = triangles[t]
    p = vec(positions, a)
    e1, e2 = sub(vec(positions, b), p), sub(vec(positions, c), p)
    n = cross(e1, e2)
    s = sub(p, eye)
    along = dot(n, away)
    distance = dot(n, s) / along
    q = cross(sub(scale(away, distance), s), n)
    unit = 1.0 / dot(n, n)
    # q · e is what is left of the cross products in the plane.
    return -dot(q, e2) * unit, dot(q, e1) * unit, distance
