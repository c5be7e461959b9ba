"""How much of a wavelet's coefficients is the chance of where rays land.

A row's coefficient sums the rays under the wavelet ψ, each with its weight w times ±|ψ|. If they
were independent, its variance would be Σ w² ψ². But their directions are those of a lattice: of m
rays that land close together only those at the rim may as well land beside it, about √m, so

    variance ≈ Σ w² ψ² min(1, 1 / √m)

In the mean over a tile's rows, with m = (Σ w)² / Σ w² of a row. Most wavelets of a row get less
than one ray: what differs from row to row is then all chance, and this says so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.hierarchy import level_of, level_start
from engine.numerics.borrow import borrow


class Landed(NamedTuple):
    """Sums of one thread over the rays of a tile, all zero between tiles.

    weight, square  (c,) float64  of every cluster
    """

    weight: NDArray[np.float64]
    square: NDArray[np.float64]


def make_landed(samples: int) -> Landed:
    """For a cloud of so many samples."""
    return Landed(*np.zeros((2, (4 * samples - 1) // 3)))


@njit(cache=True, nogil=True)
def ray_noise(cluster, weight, rows, depth, landed, noise):
    """Variance of the coefficients of every wavelet that these rays touch, in noise (4^depth,).

    cluster, weight (p,) as of `Rows`, of `rows` rows in all; other places of noise stay as they
    are.
    """
    landed = borrow(landed)
    for p in range(cluster.shape[0]):
        c = cluster[p]
        level = level_of(c)
        w = float(weight[p]) * (1 << (2 * (depth - level)))
        while w != 0.0:
            landed.weight[c] += w
            landed.square[c] += w * w
            if c == 0:
                break
            c = (c - 1) // 4
    for p in range(cluster.shape[0]):
        c = cluster[p]
        level = level_of(c)
        # What has been cleared has been reckoned, and all above it.
        while landed.square[c] > 0.0:
            square = landed.square[c] / rows
            rays = (landed.weight[c] / rows) ** 2 / square
            variance = square / (1 << (2 * (depth - level))) * min(1.0, rays**-0.5)
            landed.weight[c] = landed.square[c] = 0.0
            if level < depth:
                first = (1 << (2 * level)) + 3 * (c - level_start(level))
                noise[first : first + 3] = variance
            if c == 0:
                noise[0] = variance
                break
            c = (c - 1) // 4
            level -= 1
