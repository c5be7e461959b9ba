"""Curves over an angle as sums of boxes or tents: the one-dimensional basis of `brdf_editing`.

Ben-Artzi, Egan, Ramamoorthi, Durand 2008, appendix A, have boxes, one for each band of the angle.
A tent reaches over two bands, so that the sum is a line from node to node: every ray of light
counts for two of them, and nothing in a picture shows where a band ends. Of a lobe with exponent
100 (1,000) 64 boxes leave 4 % (7 %) out, 64 tents 0.1 % (0.3 %), 16 tents still less than 64 boxes.
Bands are narrow where the angle is small, see `half_angle`; of equal width, 64 boxes would
leave 22 % of exponent 1,000 out.
"""

from __future__ import annotations

from functools import cache
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.half_angle import angle_of
from engine.brdf.layers import Layers

Basis = Literal["tents", "boxes"]

FINE = 16  # points of each band that a curve is looked up at


@njit
def weights_at(u, count, tents):
    """(first, share of it, share of the next) of `count` elements at a place u in [0, 1]."""
    if not tents:
        return min(int(u * count), count - 1), 1.0, 0.0
    x = u * (count - 1)
    k = min(int(x), count - 2)
    return k, 1.0 - (x - k), x - k


@cache
def _fit(count: int, basis: Basis) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(angles (n,), (count, n)): what takes a curve at the angles to its nearest coefficients.

    Nearest as its square is weighed by sin 2γ, which is that of facets under even light.
    """
    tents = basis == "tents"
    bands = count - 1 if tents else count
    nodes, weight = np.polynomial.legendre.leggauss(FINE)
    u = ((np.arange(bands)[:, None] + 0.5 * (nodes + 1)) / bands).ravel()
    measure = np.tile(weight, bands) * 8 * (1 - u**4) * u**3
    shape = np.zeros((count, len(u)))
    for q, place in enumerate(u):
        k, here, there = weights_at.py_func(place, count, tents)
        shape[k, q] = here
        if there:
            shape[k + 1, q] = there
    weighed = shape * measure
    return angle_of(u), np.asarray(np.linalg.solve(weighed @ shape.T, weighed), np.float64)


def coefficients(
    layers: Layers, row: NDArray[np.float32], count: int, basis: Basis
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(colours (constants, 3), curves (curves, count, 3)) of a material's row."""
    angles, fit = _fit(count, basis)
    lobes = layers.lobes(row, angles)
    return layers.colours(row), fit @ lobes
