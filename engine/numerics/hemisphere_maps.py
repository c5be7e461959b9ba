"""Functions over the upper hemisphere as square textures, looked up bilinearly.

Two parametrisations of `glossy_prt` (Wang, Tran, Luebke 2006, §3.3.2), of local directions w, z up:

    disk   x = (w_x + 1) / 2, y = (w_y + 1) / 2                                           eq. 10
    polar  x = atan2(w_x, w_y) / 2π, y = √(1 - w_z)                                       eq. 11

A texture of n x n texels has texel (i, j) at the centre ((i + 1/2) / n, (j + 1/2) / n); its number
is j n + i. The disk leaves the corners of the square out; those texels at and just beyond its rim
that a look-up within may reach are *guards*, and stand for the direction where the line to the
centre crosses the rim, if it does. The polar map goes on over its left and right edge, and at
y = 0, where all azimuths are one direction, into the column that lies opposite: it has no seam, and
its pole is as smooth as what it holds.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec

RIM = 1e-3  # z of the guards beyond the rim: below the horizon there is nothing to look up
# Texels with their centre nearer to the rim, in halves of a texel, are guards as well: by chance
# some of them lie so close to the horizon that a BRDF is thousands there and outweighs all others.
EDGE = 0.5


class Texels(NamedTuple):
    """The m texels of a map that a look-up can reach, those that are no guards first.

    size        n
    polar       which of the two parametrisations
    number      (m,) int64    j n + i
    direction   (m, 3)        unit, at the centre
    weight      (inner,)      projected solid angle of those that are no guards, up to a factor
    """

    size: int
    polar: bool
    number: NDArray[np.int64]
    direction: NDArray[np.float64]
    weight: NDArray[np.float64]


def texels(size: int, *, polar: bool = False) -> Texels:
    """The texels of a map; a polar one needs an even size, or its columns have no opposite."""
    centre = (np.arange(size) + 0.5) / size
    x, y = (a.ravel() for a in np.meshgrid(centre, centre))
    number = np.arange(size * size)
    if polar:
        if size % 2:
            raise ValueError(f"a polar map has an even size, not {size}")
        z = 1.0 - y * y
        r = y * np.sqrt(2.0 - y * y)
        w = np.stack([r * np.sin(2 * np.pi * x), r * np.cos(2 * np.pi * x), z], axis=1)
        # dω = 2 y dy dφ.
        return Texels(size, True, number, w, y * z)
    x, y = 2.0 * x - 1.0, 2.0 * y - 1.0
    radius = np.hypot(x, y)
    inner = radius < 1.0 - EDGE / size
    # A look-up within the disk reaches one texel far each way.
    step = 2.0 / size
    near = np.hypot(np.maximum(np.abs(x) - step, 0), np.maximum(np.abs(y) - step, 0)) < 1.0
    guard = ~inner & near
    rim = np.sqrt(1.0 - RIM * RIM)
    shrink = np.minimum(1.0, rim / radius)
    x, y = x * shrink, y * shrink
    w = np.stack([x, y, np.sqrt(np.maximum(1.0 - x * x - y * y, 0))], axis=1)
    order = np.concatenate([np.flatnonzero(inner), np.flatnonzero(guard)])
    # Equal areas of the disk are equal projected solid angles.
    return Texels(size, False, number[order], w[order], np.ones(int(inner.sum())))


def mirrors(grid: Texels) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which of the inner texels lies where each one's w_x, each one's w_y is negated: (inner,)."""
    number = grid.number[: len(grid.weight)]
    n, place = grid.size, np.zeros(grid.size**2, np.int64)
    place[number] = np.arange(len(number))
    j, i = np.divmod(number, n)
    if grid.polar:
        return place[j * n + n - 1 - i], place[j * n + (n // 2 - 1 - i) % n]
    return place[j * n + n - 1 - i], place[(n - 1 - j) * n + i]


@njit
def disk_taps(w, size):
    """(four texel numbers, (fx, fy)): neighbours of w, of which fx, fy weigh the second ones."""
    x, y = 0.5 * (w[0] + 1.0) * size - 0.5, 0.5 * (w[1] + 1.0) * size - 0.5
    i, j = math.floor(x), math.floor(y)
    i0, i1 = max(0, int(i)), min(size - 1, int(i) + 1)
    j0, j1 = max(0, int(j)), min(size - 1, int(j) + 1)
    rows = (j0 * size, j1 * size)
    return (rows[0] + i0, rows[0] + i1, rows[1] + i0, rows[1] + i1), (x - i, y - j)


@njit
def polar_taps(w, size):
    """The same of a polar map."""
    # √(1 - z), with its digits near the pole.
    radius = math.sqrt((w[0] * w[0] + w[1] * w[1]) / (1.0 + w[2]))
    x = math.atan2(w[0], w[1]) / (2.0 * math.pi) * size - 0.5
    y = radius * size - 0.5
    i, j = math.floor(x), math.floor(y)
    i0, i1 = int(i) % size, (int(i) + 1) % size
    j1 = min(size - 1, int(j) + 1) * size
    if j < 0.0:
        half = size // 2
        return ((i0 + half) % size, (i1 + half) % size, j1 + i0, j1 + i1), (x - i, y - j)
    j0 = min(size - 1, int(j)) * size
    return (j0 + i0, j0 + i1, j1 + i0, j1 + i1), (x - i, y - j)


def look_up(
    maps: NDArray[np.float32], directions: NDArray[np.floating], *, polar: bool
) -> NDArray[np.float64]:
    """(q, c): maps (n, n, c) at local directions (q, 3), unit, z > 0."""
    size, channels = maps.shape[0], maps.shape[2]
    flat = np.ascontiguousarray(maps.reshape(size * size, channels), np.float32)
    w = np.ascontiguousarray(directions, np.float64)
    out = np.zeros((len(w), channels))
    for_ranges(_look_up, len(w), flat, size, polar, w, out)
    return out


@njit(cache=True, nogil=True)
def _look_up(start, stop, maps, size, polar, w, out):
    for q in range(start, stop):
        d = vec(w, q)
        taps, (fx, fy) = polar_taps(d, size) if polar else disk_taps(d, size)
        a, b = (1.0 - fx) * (1.0 - fy), fx * (1.0 - fy)
        c, e = (1.0 - fx) * fy, fx * fy
        for k in range(maps.shape[1]):
            out[q, k] = (
                a * maps[taps[0], k]
                + b * maps[taps[1], k]
                + c * maps[taps[2], k]
                + e * maps[taps[3], k]
            )
