"""All values of a code, by the kernels."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.wavelet.synthesis import synthesise
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec

Directions = NDArray[np.float64]


def values_of(
    data: NDArray[np.uint8], wi: Directions, wo: Directions, level: int = 0
) -> NDArray[np.float64]:
    """(n, m, 3) sr⁻¹ of a code's bytes, by the kernels: incident (m, 3), outgoing (n, 3)."""
    out = np.zeros((len(wo), len(wi), 3))
    octets = np.ascontiguousarray(data)
    address = np.uint64(octets.ctypes.data)
    args = (address, np.ascontiguousarray(wi), np.ascontiguousarray(wo), level, out)
    for_ranges(_all_pairs, len(wo), *args, grain=16)
    return out


@njit(cache=True, nogil=True)
def _all_pairs(start, stop, a, wi, wo, level, out):
    for o in range(start, stop):
        for i in range(len(wi)):
            r, g, b = synthesise(a, vec(wi, i), vec(wo, o), level)
            out[o, i, 0], out[o, i, 1], out[o, i, 2] = r, g, b
