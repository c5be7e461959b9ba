"""Finer rows of environment samples where the sky is seen through openings.

Rays that follow the cosine find a window a few times only, and what a point gets through it would
be noise. But the rays of a tile's 64 points together show through which cells of the sphere the
environment is seen from there at all. Each of those *open* cells is cut into as many smaller ones
as a budget allows, and each point shoots one ray into each of them:

    E_xc = V(x, d) cos θ Ω_c,    d random in cell c, Ω_c = 4π / 4^level

Only cells that an edge crosses are uncertain then.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.hierarchy import level_start
from engine.numerics.octahedron import cell, corner, direction
from engine.numerics.sampling import uniform
from engine.numerics.vec import add, dot, scale, vec

LEVEL = 5  # of the cells that are open or not: 6.4 degrees wide
JITTER = 1 << 22  # dimensions of `uniform` from here on place the rays in their cells


def open_cells(free: NDArray[np.bool_], direction: NDArray[np.float32]) -> NDArray[np.int32]:
    """Cells (m,) of LEVEL that one of the rays (r,) which are free falls into, ascending."""
    is_open = np.zeros(4**LEVEL, np.bool_)
    _mark(free, direction, is_open)
    return np.flatnonzero(is_open).astype(np.int32)


def refinement(cells: int, rays: int, depth: int) -> int:
    """Levels below LEVEL, up to `depth`, at which so many cells take no more than `rays`."""
    deeper = 0
    while LEVEL + deeper < depth and cells << 2 * (deeper + 1) <= rays:
        deeper += 1
    return deeper


@njit(cache=True, nogil=True)
def _mark(free, direction, is_open):
    for r in range(free.shape[0]):
        if free[r]:
            is_open[cell(vec(direction, r), LEVEL)] = True


@njit(cache=True, nogil=True)
def aim_through(
    index, position, normal, geometric, cells, deeper, depth, epsilon, seed, origin, direction_,
    first, cluster, weight,
):  # fmt: skip
    """One ray from each of the points `index` (b,) into each part of the open cells (m,).

    Fills origin, direction_ (r, 3), cluster (r,) and weight (r,), what each environment sample of
    the cluster adds; first (b + 1,). Returns the number of rays; -1 is no point and has none.
    """
    level = LEVEL + deeper
    side = 2.0 / (1 << level)
    solid = 4.0 * math.pi / (1 << (2 * depth))
    rays = 0
    for b in range(index.shape[0]):
        first[b] = rays
        i = index[b]
        if i < 0:
            continue
        n, g = vec(normal, i), vec(geometric, i)
        start = add(vec(position, i), scale(g, epsilon))
        for m in range(cells.shape[0]):
            for part in range(cells[m] << 2 * deeper, cells[m] + 1 << 2 * deeper):
                u, v = corner(part, level)
                dimension = JITTER + 2 * part
                d = direction(
                    u + side * uniform(seed, i, dimension),
                    v + side * uniform(seed, i, dimension + 1),
                )
                cosine = dot(d, n)
                if cosine <= 0.0 or dot(d, g) <= 0.0:
                    continue
                for c in range(3):
                    origin[rays, c] = start[c]
                    direction_[rays, c] = d[c]
                cluster[rays] = level_start(level) + part
                weight[rays] = cosine * solid
                rays += 1
    first[index.shape[0]] = rays
    return rays
