"""The display transform: exposure, then the sRGB curve of IEC 61966-2-1, at the very end."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from engine.numerics.parallel import for_ranges


def srgb_from_linear(linear: ArrayLike) -> NDArray[np.float64]:
    """sRGB signal in [0, 1] of linear light, any shape.

    What is negative or not a number becomes black, what is above 1 white.
    """
    x = np.clip(np.nan_to_num(np.asarray(linear, np.float64), nan=0.0), 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - 0.055)


def linear_from_srgb(signal: ArrayLike) -> NDArray[np.float64]:
    """Linear light of an sRGB signal in [0, 1], any shape."""
    x = np.asarray(signal, np.float64)
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def to_srgb(image: NDArray[np.float32], exposure: float = 0.0) -> NDArray[np.float64]:
    """Signal in [0, 1] for a screen, in the shape of `image`; exposure in stops, 1 doubles."""
    return srgb_from_linear(np.asarray(image, np.float64) * 2.0**exposure)


# The curve is steepest at 0, where one of these steps is a twentieth of an 8-bit step.
_STEPS = 65535
_BYTES = np.round(255 * srgb_from_linear(np.arange(_STEPS + 1) / _STEPS)).astype(np.uint8)


def to_srgb8(image: NDArray[np.float32], exposure: float = 0.0) -> NDArray[np.uint8]:
    """`to_srgb` in bytes for a screen, in the shape of `image`, fast.

    A byte may differ by one from the rounded signal where that is half-way between two bytes.
    """
    flat = np.ascontiguousarray(image, np.float32).reshape(-1)
    out = np.zeros(flat.shape, np.uint8)
    for_ranges(_to_bytes, len(flat), flat, np.float32(2.0**exposure), _BYTES, out, grain=65536)
    return out.reshape(image.shape)


@njit(cache=True, nogil=True)
def _to_bytes(start, stop, image, gain, table, out):
    last = table.shape[0] - 1
    for i in range(start, stop):
        x = image[i] * gain
        # A NaN fails both comparisons.
        if x >= 1.0:
            out[i] = table[last]
        elif x > 0.0:
            out[i] = table[int(x * last + 0.5)]
        else:
            out[i] = table[0]
