"""The sphere as a square of equal areas, in quad-tree order.

The sphere is flattened over an octahedron (Clarberg 2008, *Fast Equal-Area Mapping of the
(Hemi)Sphere using SIMD*): the upper half (+y) becomes a square that stands on its corner, the lower
half the four triangles around it. Equal areas stay equal, so that each of the 4^k cells of the
square is a direction with solid angle 4π / 4^k. Cells are numbered by Morton code, the order that
`engine.numerics.haar` and the cluster hierarchies have.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.parallel import for_ranges


@njit
def square(d):
    """(u, v) in [-1, 1] of a unit direction d; (0, 0) is +y, the corners are -y."""
    # r is 1 on the horizon: an area of the upper half is proportional to 1 - y = r².
    r = math.sqrt(max(0.0, 1.0 - abs(d[1])))
    if r == 0.0:
        u = v = 0.0
    else:
        v = math.atan2(abs(d[2]), abs(d[0])) * (2.0 / math.pi) * r
        u = r - v
    if d[1] < 0.0:
        u, v = 1.0 - v, 1.0 - u
    return math.copysign(u, d[0]), math.copysign(v, d[2])


@njit
def direction(u, v):
    """The unit direction of (u, v) in [-1, 1]."""
    a, b = abs(u), abs(v)
    below = a + b > 1.0
    if below:
        a, b = 1.0 - b, 1.0 - a
    r = a + b
    phi = 0.5 * math.pi * (b / r if r > 0.0 else 0.0)
    y = 1.0 - r * r
    s = r * math.sqrt(max(0.0, 2.0 - r * r))
    return (
        math.copysign(s * math.cos(phi), u),
        -y if below else y,
        math.copysign(s * math.sin(phi), v),
    )


@njit
def beyond(u, v):
    """The direction of (u, v) that may lie over an edge of the square, where the sphere goes on."""
    if abs(u) > 1.0:
        u, v = math.copysign(2.0 - abs(u), u), -v
    if abs(v) > 1.0:
        u, v = -u, math.copysign(2.0 - abs(v), v)
    return direction(u, v)


@njit
def cell(d, depth):
    """Number of the cell, one of 4^depth, that a unit direction d falls into."""
    u, v = square(d)
    side = 1 << depth
    x = min(side - 1, int(0.5 * (u + 1.0) * side))
    y = min(side - 1, int(0.5 * (v + 1.0) * side))
    code = 0
    for bit in range(depth):
        code |= ((x >> bit & 1) | (y >> bit & 1) << 1) << 2 * bit
    return code


def centres(depth: int) -> NDArray[np.float64]:
    """(4^depth, 3) float64: the directions of the cells' centres, in their order."""
    out = np.zeros((4**depth, 3))
    for_ranges(_centres, len(out), depth, out)
    return out


@njit
def corner(code, depth):
    """(u, v) of the lower corner of a cell, whose sides are 2 / 2^depth long."""
    x = y = 0
    for bit in range(depth):
        x |= (code >> 2 * bit & 1) << bit
        y |= (code >> (2 * bit + 1) & 1) << bit
    return 2.0 * x / (1 << depth) - 1.0, 2.0 * y / (1 << depth) - 1.0


@njit(cache=True, nogil=True)
def _centres(start, stop, depth, out):
    half = 1.0 / (1 << depth)
    for code in range(start, stop):
        u, v = corner(code, depth)
        d = direction(u + half, v + half)
        for k in range(3):
            out[code, k] = d[k]
