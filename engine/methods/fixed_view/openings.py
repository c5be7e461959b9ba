"""Finer rows of environment samples where the sky is seen through openings.

Rays that follow a lobe find a window a few times only, and what a point gets through it would be
noise. But the rays of a tile's 64 points together show through which cells of the sphere the
environment is seen from there at all. Each of those *open* cells is cut into k x k smaller ones, as
many as a budget allows, and every point shoots one more ray into each. A free ray in direction d,
of whichever kind, then counts with the balance heuristic (Veach, Guibas 1995): it adds

    π / a · f cos θ / (N p(d) + k² 4^LEVEL / 4π)

to its environment sample, with N, f, p and a as in `gather_rays`; the last term is the density of
the second kind, 0 where the cell of d is not open.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdfs
from engine.brdf.base import luminance
from engine.methods.fixed_view.gather_rays import shading_frame
from engine.methods.fixed_view.hierarchy import level_start
from engine.numerics.borrow import borrow
from engine.numerics.frames import to_local
from engine.numerics.octahedron import beyond, corner, direction
from engine.numerics.octahedron import cell as cell_of
from engine.numerics.sampling import uniform
from engine.numerics.vec import add, dot, scale, vec

evaluate, density = brdfs.evaluate, brdfs.pdf
LEVEL = 5  # of the cells that are open or not: 6.4 degrees wide
PER_STERADIAN = 4**LEVEL / (4 * math.pi)
JITTER = 1 << 22  # dimensions of `uniform` from here on place the rays in their cells
NOTHING = 1e-6  # a ray that would weigh less, of π in all, is not shot


def open_cells(free: NDArray[np.bool_], direction: NDArray[np.float32]) -> NDArray[np.bool_]:
    """(4^LEVEL,) bool: cells that one of the rays (r,) which are free falls into, or beside.

    Beside, because rays of the cosine seldom find what a surface sees at a grazing angle.
    """
    found, is_open = np.zeros((2, 4**LEVEL), np.bool_)
    _mark(free, direction, found)
    _grow(found, is_open)
    return is_open


@njit(cache=True, nogil=True)
def _mark(free, direction, found):
    for r in range(free.shape[0]):
        if free[r]:
            found[cell_of(vec(direction, r), LEVEL)] = True


@njit(cache=True, nogil=True)
def _grow(found, is_open):
    side = 2.0 / (1 << LEVEL)
    for c in range(found.shape[0]):
        if not found[c]:
            continue
        u, v = corner(c, LEVEL)
        for dy in range(-1, 2):
            for dx in range(-1, 2):
                is_open[cell_of(beyond(u + (dx + 0.5) * side, v + (dy + 0.5) * side), LEVEL)] = True


@njit(cache=True, nogil=True)
def share(
    index, normal, view, model, row, count, is_open, k, first, direction, free, weight
):  # fmt: skip
    """Leave the rays of the first kind which are free (r,) their share of their weight (r,)."""
    rows = borrow(row)
    for b in range(index.shape[0]):
        i = index[b]
        if i < 0:
            continue
        n, s, t, wo = shading_frame(normal, view, i)
        for r in range(first[b], first[b + 1]):
            d = vec(direction, r)
            if free[r] and is_open[cell_of(d, LEVEL)]:
                mine = count * density(model[i], rows[i], to_local(d, s, t, n), wo)
                weight[r] *= mine / (mine + k * k * PER_STERADIAN)


@njit(cache=True, nogil=True)
def aim_through(
    index, position, normal, geometric, view, model, row, count, norm, cells, k, depth, epsilon,
    seed, origin, direction_, first, cluster, weight,
):  # fmt: skip
    """One ray from each of the points `index` (b,) into each of the k x k parts of cells (m,).

    norm (b,) is π / (a N) of `gather_rays.aim`. Fills origin, direction_ (r, 3), cluster (r,) of
    the tree over 4^depth samples and weight (r,); first (b + 1,). Returns the number of rays.
    """
    rows = borrow(row)
    # The samples of a cluster share a ray that stands for a direction as wide as the cluster.
    level = LEVEL
    while level < depth and 1 << (level + 1 - LEVEL) <= k:
        level += 1
    spread = 1.0 / (1 << (2 * (depth - level)))
    side = 2.0 / (1 << LEVEL) / k
    rays = 0
    for b in range(index.shape[0]):
        first[b] = rays
        i = index[b]
        if i < 0:
            continue
        n, s, t, wo = shading_frame(normal, view, i)
        g = vec(geometric, i)
        start = add(vec(position, i), scale(g, epsilon))
        for m in range(cells.shape[0]):
            u, v = corner(cells[m], LEVEL)
            for part in range(k * k):
                dimension = JITTER + 2 * (cells[m] * k * k + part)
                x = part % k + uniform(seed, i, dimension)
                y = part // k + uniform(seed, i, dimension + 1)
                d = direction(u + side * x, v + side * y)
                wi = to_local(d, s, t, n)
                if wi[2] <= 0.0 or dot(d, g) <= 0.0:
                    continue
                f = luminance(evaluate(model[i], rows[i], wi, wo)) * wi[2]
                both = count * density(model[i], rows[i], wi, wo) + k * k * PER_STERADIAN
                w = norm[b] * count * f / both
                if w < NOTHING * math.pi:
                    continue
                for c in range(3):
                    origin[rays, c] = start[c]
                    direction_[rays, c] = d[c]
                cluster[rays] = level_start(level) + cell_of(d, level)
                weight[rays] = w * spread
                rays += 1
    first[index.shape[0]] = rays
    return rays
