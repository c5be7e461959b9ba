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
    """Sums of one thread over the rays of a row, all zero between rows.

    weight, square  (c,) float64  of every cluster
    """

    weight: NDArray[np.float64]
    square: NDArray[np.float64]


def make_landed(samples: int) -> Landed:
    """For a cloud of so many samples."""
    return Landed(*np.zeros((2, (4 * samples - 1) // 3)))


@njit(cache=True, nogil=True)
def ray_noise(first, cluster, weight, count, chance, depth, landed, noise):
    """Variance of the coefficients of wavelets, in the mean over `count` rows.

    first, cluster, weight are `Rows`. chance is 1 for rays of a lattice, or STRATIFIED. Fills the
    places in noise (4^depth,) of wavelets that rays touch, and leaves the others as they are.
    """
    landed = borrow(landed)
    for p in range(first[0], first[first.shape[0] - 1]):
        c, level = _above(cluster[p])
        while True:
            _set(noise, c, level, 0.0)
            if c == 0:
                break
            c, level = (c - 1) // 4, level - 1
    for b in range(first.shape[0] - 1):
        for p in range(first[b], first[b + 1]):
            w = float(weight[p]) * (1 << (2 * (depth - level_of(cluster[p]))))
            c, level = _above(cluster[p])
            while w != 0.0:
                landed.weight[c] += w
                landed.square[c] += w * w
                if c == 0:
                    break
                c = (c - 1) // 4
        for p in range(first[b], first[b + 1]):
            c, level = _above(cluster[p])
            # What has been cleared has been reckoned, and all above it.
            while landed.square[c] > 0.0:
                square, rays = landed.square[c], landed.weight[c] ** 2 / landed.square[c]
                variance = chance * square * min(1.0, rays**-0.5) / (1 << (2 * (depth - level)))
                _set(noise, c, level, noise[_wavelet(c, level)] + variance / count)
                landed.weight[c] = landed.square[c] = 0.0
                if c == 0:
                    break
                c, level = (c - 1) // 4, level - 1


@njit
def _above(cluster):
    """(cluster, level) of the parent: within a cluster its weight is even, and no wavelet gets any.

    The root stands for its own.
    """
    c = max(0, (cluster - 1) // 4)
    return c, level_of(c)


@njit
def _wavelet(c, level):
    """The first of a cluster's three wavelets."""
    return (1 << (2 * level)) + 3 * (c - level_start(level))


@njit
def _set(noise, c, level, variance):
    """Of a cluster's wavelets; the root has the scaling function too."""
    k = _wavelet(c, level)
    noise[k : k + 3] = variance
    if c == 0:
        noise[0] = variance
