"""The product of sparse transport vectors with a light: `glossy_prt` eq. 5, §4.3."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.cube_map import FACES
from engine.numerics.parallel import for_ranges


def multiply_vectors(
    start: NDArray[np.int64],
    base: NDArray[np.float32],
    scale: NDArray[np.float32],
    place: NDArray[np.uint16],
    steps: NDArray[np.int8],
    light: NDArray[np.float32],
    channels: int,
) -> NDArray[np.float32]:
    """The terms of each vector times the light, (r · K, 3) float32.

    start (r + 1,), base (r, 6, c), scale (r, c), place (q,), steps (q, c) are `WaveletVectors` of
    c = K · channels: the K terms, once if they are grey, else of red, of green, of blue.
    light (6 n², 3) float32 holds the Haar coefficients of its faces.
    """
    terms = scale.shape[1] // channels
    out = np.zeros((len(scale), terms, 3), np.float32)
    size = len(light) // FACES
    kernel = _kernel(terms, channels)
    for_ranges(kernel, len(out), start, base, scale, place, steps, light, size, out, grain=256)
    return out.reshape(-1, 3)


@cache
def _kernel(terms: int, channels: int) -> Any:
    """With constant numbers of terms and channels, so that inner loops become vectors."""
    green_first, blue_first = (0, 0) if channels == 1 else (terms, 2 * terms)

    @njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
    def multiply(begin, end, start, base, scale, place, steps, light, size, out):
        red, green, blue = np.zeros((3, terms), np.float32)
        for r in range(begin, end):
            red[:] = 0
            green[:] = 0
            blue[:] = 0
            for k in range(start[r], start[r + 1]):
                p = place[k]
                x, y, z = light[p, 0], light[p, 1], light[p, 2]
                for j in range(terms):
                    red[j] += np.float32(steps[k, j]) * x
                    green[j] += np.float32(steps[k, green_first + j]) * y
                    blue[j] += np.float32(steps[k, blue_first + j]) * z
            for j in range(terms):
                red[j] *= scale[r, j]
                green[j] *= scale[r, green_first + j]
                blue[j] *= scale[r, blue_first + j]
            for f in range(FACES):
                x, y, z = light[f * size, 0], light[f * size, 1], light[f * size, 2]
                for j in range(terms):
                    red[j] += base[r, f, j] * x
                    green[j] += base[r, f, green_first + j] * y
                    blue[j] += base[r, f, blue_first + j] * z
            for j in range(terms):
                out[r, j, 0], out[r, j, 1], out[r, j, 2] = red[j], green[j], blue[j]

    return multiply
