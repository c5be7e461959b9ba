"""How far the values of a code are from those that were encoded."""

from __future__ import annotations

from dataclasses import asdict, dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.wavelet.analysis import Grid
from engine.brdf.wavelet.synthesis import synthesise
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec

Directions = NDArray[np.float64]


@dataclass(frozen=True)
class Errors:
    """Of values v against those that are right, over all samples and channels.

    mean   of |off| / (right + ε · the channel's mean)
    p99    99th percentile of the same
    rms    root mean square of what it is off, sr⁻¹
    light  part of all light, from everywhere, that is reflected where it should not be
    """

    mean: float
    p99: float
    rms: float
    light: float

    def as_dict(self) -> dict[str, float]:
        """As JSON."""
        return asdict(self)


def errors_of(found: NDArray, right: NDArray[np.floating], grid: Grid, floor: float) -> Errors:
    """Of tables (θ, φ, down, across, 3) on a grid; floor is ε."""
    right = np.asarray(right, np.float64)
    off = np.abs(found - right)
    relative = off / (right + floor * right.mean(axis=(0, 1, 2, 3)) + 1e-30)
    share = np.multiply.outer(*grid.weights)[..., None, None] * grid.incident_weights
    light = np.einsum("abcdk,abcd->", right, share)
    wrong = np.einsum("abcdk,abcd->", off, share)
    return Errors(
        float(relative.mean()),
        float(np.quantile(relative, 0.99)),
        float(np.sqrt((off**2).mean())),
        float(wrong / (2 * light)) if light > 0 else 0.0,
    )


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
