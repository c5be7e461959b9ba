"""The product of packed rows with a light in wavelet space."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.parallel import for_ranges

TILE = 64


def multiply(
    length: NDArray[np.int32],
    ids: NDArray[np.int32],
    scale: NDArray[np.float32],
    steps: NDArray[np.int8],
    light: NDArray[np.float32],
    rows: int = TILE,
) -> NDArray[np.float32]:
    """Matrix times light: (tiles, 3, rows) float32.

    length (tiles,), ids, scale (q,), steps (q, 64) are a `PackedRows`; light (n_g, 3) float32 Haar
    coefficients; `rows` asks for the first so many rows of every tile.
    """
    tiles = len(length)
    first = np.concatenate([[0], np.cumsum(length)])
    out = np.zeros((tiles, 3, rows), np.float32)
    kernel = _multiply_all if rows == TILE else _multiply_some
    for_ranges(kernel, tiles, first, ids, scale, steps, np.ascontiguousarray(light), out, grain=16)
    return out


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _multiply_all(start, stop, first, ids, scale, steps, light, out):
    # The row count is a constant here, so the inner loop becomes a few vector instructions.
    for t in range(start, stop):
        red, green, blue = out[t, 0], out[t, 1], out[t, 2]
        for k in range(first[t], first[t + 1]):
            w, s = ids[k], scale[k]
            r, g, b = s * light[w, 0], s * light[w, 1], s * light[w, 2]
            step = steps[k]
            for p in range(64):
                x = np.float32(step[p])
                red[p] += x * r
                green[p] += x * g
                blue[p] += x * b


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _multiply_some(start, stop, first, ids, scale, steps, light, out):
    for t in range(start, stop):
        red, green, blue = out[t, 0], out[t, 1], out[t, 2]
        for k in range(first[t], first[t + 1]):
            w, s = ids[k], scale[k]
            r, g, b = s * light[w, 0], s * light[w, 1], s * light[w, 2]
            step = steps[k]
            for p in range(out.shape[2]):
                x = np.float32(step[p])
                red[p] += x * r
                green[p] += x * g
                blue[p] += x * b
