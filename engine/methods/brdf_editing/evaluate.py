"""A frame: `brdf_editing` (Ben-Artzi et al. 2008), eq. 28."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.brdf_editing.fold import Folded
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges


def evaluate(
    others: NDArray[np.float32],
    pixels: NDArray[np.int32],
    folded: Folded,
    behind: Folded,
    albedo: NDArray[np.float32],
    coefficients: NDArray[np.float32],
    second: NDArray[np.float32],
) -> NDArray[np.float32]:
    """(n, 3) float32 radiance: the polynomials `others` (n, deg + 1, 3) and F of pixels (m,).

    albedo (3,) of the material in hand, coefficients (3, slots) of its BRDF; `behind` is F of the
    second bounce for all pixels or none, and `second` (3, slots) its coefficients.
    """
    out = np.zeros((len(others), 3), np.float32)
    for_ranges(_others, len(others), others, albedo, out)
    every = np.arange(len(behind.steps), dtype=np.int32)
    for_ranges(_hand, len(every), every, *behind, albedo, second, out, grain=512)
    for_ranges(_hand, len(pixels), pixels, *folded, albedo, coefficients, out, grain=512)
    return out


@njit(cache=True, nogil=True)
def _others(begin, end, others, albedo, out):
    for i in range(begin, end):
        for c in range(3):
            value = np.float32(0)
            for n in range(others.shape[1] - 1, -1, -1):
                value = value * albedo[c] + others[i, n, c]
            out[i, c] = value


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _hand(begin, end, pixels, steps, unit, albedo, coefficients, out):
    steps, coefficients = borrow(steps), borrow(coefficients)
    slots = coefficients.shape[1]
    for q in range(begin, end):
        i = pixels[q]
        for c in range(3):
            value, own = np.float32(0), coefficients[c]
            for n in range(steps.shape[1] - 1, -1, -1):
                total, row = np.float32(0), steps[q, n, c]
                for slot in range(slots):
                    total += np.float32(row[slot]) * own[slot]
                value = value * albedo[c] + unit[q, n] * total
            # What tents make of a lobe may be a little less than none.
            out[i, c] = max(np.float32(0), out[i, c] + value)
