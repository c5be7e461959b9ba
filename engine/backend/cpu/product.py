"""The product of packed rows with a light in wavelet space."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.parallel import for_ranges

TILE = 64


def multiply(
    ids: NDArray[np.int32],
    scale: NDArray[np.float32],
    steps: NDArray[np.int8],
    light: NDArray[np.float32],
    rows: int = TILE,
) -> NDArray[np.float32]:
    """Matrix times light: (tiles, 3, rows) float32.

    ids, scale (tiles, k), steps (tiles, k, 64) are a `PackedRows`; light (n_g, 3) float32 are Haar
    coefficients; `rows` asks for the first so many rows of every tile.
    """
    tiles = len(ids)
    out = np.zeros((tiles, 3, rows), np.float32)
    kernel = _multiply_all if rows == TILE else _multiply_some
    for_ranges(kernel, tiles, ids, scale, steps, np.ascontiguousarray(light), out, grain=16)
    return out


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _multiply_all(start, stop, ids, scale, steps, light, out):
    # The row count is a constant here, so the inner loop becomes a few vector instructions.
    for t in range(start, stop):
        red, green, blue = out[t, 0], out[t, 1], out[t, 2]
        for k in range(ids.shape[1]):
            w, s = ids[t, k], scale[t, k]
            if s == 0.0:
                continue
            r, g, b = s * light[w, 0], s * light[w, 1], s * light[w, 2]
            step = steps[t, k]
            for p in range(64):
                x = np.float32(step[p])
                red[p] += x * r
                green[p] += x * g
                blue[p] += x * b


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _multiply_some(start, stop, ids, scale, steps, light, out):
    for t in range(start, stop):
        red, green, blue = out[t, 0], out[t, 1], out[t, 2]
        for k in range(ids.shape[1]):
            w, s = ids[t, k], scale[t, k]
            if s == 0.0:
                continue
            r, g, b = s * light[w, 0], s * light[w, 1], s * light[w, 2]
            step = steps[t, k]
            for p in range(out.shape[2]):
                x = np.float32(step[p])
                red[p] += x * r
                green[p] += x * g
                blue[p] += x * b
