"""How much of a wavelet's coefficients is the chance of where rays land.

A row's coefficient sums the rays under the wavelet ψ, each with its weight w times ±|ψ|. If they
were independent, its variance would be Σ w² ψ². But their directions are those of a lattice: of m
rays that land close together only those at the rim may as well land beside it, about √m, so

    variance ≈ Σ w² ψ² min(1, 1 / √m)

with m = (Σ w)² / Σ w². Most wavelets get one ray of a row, or none: what differs from row to row is
then all chance, and this says so.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.hierarchy import level_of, level_start
from engine.numerics.borrow import borrow

# Of the chance of a lattice: rays of which each has a cell of the sphere. 0.2 to 0.6 was found.
STRATIFIED = 0.4


class Landed(NamedTuple):
    """Working memory of one thread, all zero between tiles.

    weight, square  (c,) float64  sums over the rays of a row, of every cluster
    variance        (c,) float64  of the coefficients of its three wavelets
    """

    weight: NDArray[np.float64]
    square: NDArray[np.float64]
    variance: NDArray[np.float64]


def make_landed(samples: int) -> Landed:
    """For a cloud of so many samples."""
    return Landed(*np.zeros((3, (4 * samples - 1) // 3)))


@njit(cache=True, nogil=True)
def ray_noise(first, cluster, weight, count, chance, depth, landed):
    """Fill landed.variance, in the mean over `count` rows.

    first, cluster, weight are `Rows`; chance is 1 for rays of a lattice, or STRATIFIED.
    """
    landed = borrow(landed)
    for b in range(first.shape[0] - 1):
        for p in range(first[b], first[b + 1]):
            w = float(weight[p]) * (1 << (2 * (depth - level_of(cluster[p]))))
            c = _above(cluster[p])
            while w != 0.0:
                landed.weight[c] += w
                landed.square[c] += w * w
                if c == 0:
                    break
                c = (c - 1) // 4
        for p in range(first[b], first[b + 1]):
            c = _above(cluster[p])
            # What has been cleared has been reckoned, and all above it.
            while landed.square[c] > 0.0:
                square, rays = landed.square[c], landed.weight[c] ** 2 / landed.square[c]
                height = 1.0 / (1 << (2 * (depth - level_of(c))))
                landed.variance[c] += chance * square * height * min(1.0, rays**-0.5) / count
                landed.weight[c] = landed.square[c] = 0.0
                if c == 0:
                    break
                c = (c - 1) // 4


@njit(cache=True, nogil=True)
def forget_noise(cluster, rays, landed):
    """Clear landed.variance of the first so many rays."""
    variance = borrow(landed).variance
    for p in range(rays):
        c = _above(cluster[p])
        while variance[c] > 0.0:
            variance[c] = 0.0
            c = _above(c)


@njit
def _above(c):
    """The parent, or the root: within a cluster its weight is even, and no wavelet gets any."""
    return max(0, (c - 1) // 4)


@njit
def cluster_of(wavelet):
    """Whose wavelet it is; of the scaling function, the root."""
    level = 0
    while 1 << (2 * (level + 1)) <= wavelet:
        level += 1
    return level_start(level) + max(0, wavelet - (1 << (2 * level))) // 3
