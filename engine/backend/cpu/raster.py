"""What each pixel shows, by rasterising: for cameras that move from frame to frame.

Three to four times as fast as a ray for each pixel where triangles are small. It finds what rays
through the same points would, but for ties within rounding.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.parallel import for_ranges, thread_count
from engine.numerics.vec import add, cross, dot, scale, sub, vec

# Part of a triangle by which its edges are widened, so that no crack is left between two.
ON_EDGE = 1e-6


class Drawn(NamedTuple):
    """What height · width pixels show, row by row from the top.

    triangle  (p,) int32     -1 where nothing
    b1, b2    (p,) float32   barycentrics of its second and third corner
    inverse   (p,) float32   1 / depth, 1/m; 0 where nothing
    front     (p,) bool      whether its counter-clockwise side is seen
    """

    triangle: NDArray[np.int32]
    b1: NDArray[np.float32]
    b2: NDArray[np.float32]
    inverse: NDArray[np.float32]
    front: NDArray[np.bool_]


def draw(
    positions: NDArray[np.float32],
    triangles: NDArray[np.int32],
    eye: NDArray[np.float64],
    to_pixels: NDArray[np.float64],
    near: float,
    shape: tuple[int, int],
) -> Drawn | None:
    """The nearest triangle at each pixel.

    positions (v, 3), triangles (t, 3), shape (height, width). to_pixels (3, 3) takes a direction
    from the eye to (x d, y d, d): column x, row y, of pixels whose centres are at whole numbers,
    and depth d in metres. None where something may be seen nearer than `near`: rays can tell then.
    """
    at = np.zeros((len(positions), 3))
    for_ranges(_project, len(at), positions, eye, to_pixels, at)
    height, width = shape
    n = height * width
    b1, b2, inverse = np.zeros((3, n), np.float32)
    drawn = Drawn(np.full(n, -1, np.int32), b1, b2, inverse, np.zeros(n, np.bool_))
    refused = np.zeros(height, np.bool_)
    # What is seen at a depth below `near` is no farther off than this.
    corner = np.array([(x, y, 1) for x in (-0.5, width - 0.5) for y in (-0.5, height - 0.5)])
    reach = near * float(np.linalg.norm(corner @ np.linalg.inv(to_pixels).T, axis=1).max())
    # Rows run downwards: what is counter-clockwise in space is clockwise in them.
    flip = -float(np.sign(np.linalg.det(to_pixels)))
    # Bands of rows; every band goes through all triangles.
    rows = max(1, height // (2 * thread_count()))
    for_ranges(
        _draw, height, positions, triangles, at, eye, to_pixels, near, reach, width, flip, drawn,
        refused, grain=rows,
    )  # fmt: skip
    return None if refused.any() else drawn


@njit
def _to_pixels(positions, i, eye, to_pixels):
    """(x d, y d, d) of a vertex."""
    v = sub(vec(positions, i), eye)
    return dot(v, vec(to_pixels, 0)), dot(v, vec(to_pixels, 1)), dot(v, vec(to_pixels, 2))


@njit(cache=True, nogil=True)
def _project(start, stop, positions, eye, to_pixels, out):
    """(x, y, 1 / d) of the vertices; 1 / d is not above 0 behind the eye."""
    e = (eye[0], eye[1], eye[2])
    for i in range(start, stop):
        x, y, d = _to_pixels(positions, i, e, to_pixels)
        inverse = 1.0 / d if d != 0.0 else -np.inf
        out[i, 0], out[i, 1], out[i, 2] = x * inverse, y * inverse, inverse


@njit(cache=True, nogil=True)
def _draw(
    top, end, positions, triangles, at, eye, to_pixels, near, reach, width, flip, drawn, refused
):
    e, nearest = (eye[0], eye[1], eye[2]), 1.0 / near
    for t in range(triangles.shape[0]):
        a, b, c = triangles[t]
        za, zb, zc = at[a, 2], at[b, 2], at[c, 2]
        if za <= 0.0 and zb <= 0.0 and zc <= 0.0:
            continue
        if min(za, zb, zc) <= 0.0 or max(za, zb, zc) > nearest:
            if _is_near(positions, a, b, c, e, reach):
                refused[top] = True
                return
            corners = (
                _to_pixels(positions, a, e, to_pixels),
                _to_pixels(positions, b, e, to_pixels),
                _to_pixels(positions, c, e, to_pixels),
            )
            _draw_beyond(top, end, t, corners, near, width, flip, drawn)
            continue
        xa, ya, xb, yb, xc, yc = at[a, 0], at[a, 1], at[b, 0], at[b, 1], at[c, 0], at[c, 1]
        y0, y1 = _within(min(ya, yb, yc), max(ya, yb, yc), top, end)
        x0, x1 = _within(min(xa, xb, xc), max(xa, xb, xc), 0, width)
        if y0 >= y1 or x0 >= x1:
            continue
        area = (xb - xa) * (yc - ya) - (xc - xa) * (yb - ya)
        if area == 0.0:
            continue
        unit, front = 1.0 / area, area * flip > 0.0
        # Barycentrics of b and c are linear over the picture, as 1 / d is.
        bx, by = (yc - ya) * unit, (xa - xc) * unit
        cx, cy = (ya - yb) * unit, (xb - xa) * unit
        for y in range(y0, y1):
            for x in range(x0, x1):
                b1 = (x - xa) * bx + (y - ya) * by
                b2 = (x - xa) * cx + (y - ya) * cy
                if b1 < -ON_EDGE or b2 < -ON_EDGE or b1 + b2 > 1.0 + ON_EDGE:
                    continue
                z = za + b1 * (zb - za) + b2 * (zc - za)
                _mark(drawn, y * width + x, t, b1 * zb, b2 * zc, z, front)


@njit
def _within(low, high, start, stop):
    """The whole numbers from low to high of those in [start, stop), as a range's two ends."""
    return max(start, math.ceil(low)), min(stop, math.floor(high) + 1)


@njit
def _mark(drawn, i, t, part1, part2, z, front):
    """Show triangle t at pixel i where nothing nearer is: 1 / d is z, of which corners have parts.

    Over the picture parts are linear; parts of 1 / d are barycentrics.
    """
    if np.float32(z) > drawn.inverse[i]:
        drawn.triangle[i], drawn.inverse[i], drawn.front[i] = t, z, front
        drawn.b1[i], drawn.b2[i] = part1 / z, part2 / z


@njit
def _is_near(positions, a, b, c, eye, reach):
    """Whether the box around a triangle comes nearer to the eye than `reach`."""
    square = 0.0
    for axis in range(3):
        p, q, r = positions[a, axis], positions[b, axis], positions[c, axis]
        off = max(0.0, min(p, q, r) - eye[axis], eye[axis] - max(p, q, r))
        square += off * off
    return square < reach * reach


@njit
def _draw_beyond(top, end, t, corners, near, width, flip, drawn):
    """Draw the part of a triangle that is deeper than `near`, of one that goes on behind the eye.

    A ray (x, y, 1) is the sum of the corners (x d, y d, d) times the parts that they have of 1 / d
    where it meets the triangle (Olano and Greer 1997, *Triangle Scan Conversion Using 2D
    Homogeneous Coordinates*).
    """
    left, right, low, high = np.inf, -np.inf, np.inf, -np.inf
    for k in range(3):
        p, q = corners[k], corners[(k + 1) % 3]
        if (p[2] > near) != (q[2] > near):
            p = add(p, scale(sub(q, p), (near - p[2]) / (q[2] - p[2])))
            left, right = min(left, p[0] / near), max(right, p[0] / near)
            low, high = min(low, p[1] / near), max(high, p[1] / near)
        p = corners[k]
        if p[2] > near:
            left, right = min(left, p[0] / p[2]), max(right, p[0] / p[2])
            low, high = min(low, p[1] / p[2]), max(high, p[1] / p[2])
    a, b, c = corners
    of_a, of_b, of_c = cross(b, c), cross(c, a), cross(a, b)
    volume = dot(a, of_a)
    if volume == 0.0 or left > right:
        return
    y0, y1 = _within(low, high, top, end)
    x0, x1 = _within(left, right, 0, width)
    unit, front = 1.0 / volume, volume * flip > 0.0
    for y in range(y0, y1):
        for x in range(x0, x1):
            ray = (float(x), float(y), 1.0)
            part0, part1, part2 = (
                unit * dot(of_a, ray),
                unit * dot(of_b, ray),
                unit * dot(of_c, ray),
            )
            z = part0 + part1 + part2
            if min(part0, part1, part2) >= -ON_EDGE * z and 0.0 < z < 1.0 / near:
                _mark(drawn, y * width + x, t, part1, part2, z, front)
