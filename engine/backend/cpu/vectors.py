"""The product of sparse transport vectors with a light: `glossy_prt` eq. 5, §4.3."""

from __future__ import annotations

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
) -> NDArray[np.float32]:
    """Each vector times the light, (r, 3) float32.

    start (r + 1,), base (r, 6, c), scale (r, c), place (q,), steps (q, c) are `WaveletVectors`,
    grey or in three channels; light (6 n², 3) float32 the Haar coefficients of its faces.
    """
    out = np.zeros((len(scale), 3), np.float32)
    size = len(light) // FACES
    kernel = _grey if scale.shape[1] == 1 else _coloured
    # Four numbers a coefficient: one load, aligned.
    wide = np.zeros((len(light), 4), np.float32)
    wide[:, :3] = light
    for_ranges(kernel, len(out), start, base, scale, place, steps, wide, size, out, grain=256)
    return out


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _grey(begin, end, start, base, scale, place, steps, light, size, out):
    for r in range(begin, end):
        red = green = blue = np.float32(0)
        for k in range(start[r], start[r + 1]):
            p, s = place[k], np.float32(steps[k, 0])
            red += s * light[p, 0]
            green += s * light[p, 1]
            blue += s * light[p, 2]
        unit = scale[r, 0]
        red, green, blue = unit * red, unit * green, unit * blue
        for f in range(FACES):
            s = base[r, f, 0]
            red += s * light[f * size, 0]
            green += s * light[f * size, 1]
            blue += s * light[f * size, 2]
        out[r, 0], out[r, 1], out[r, 2] = red, green, blue


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _coloured(begin, end, start, base, scale, place, steps, light, size, out):
    for r in range(begin, end):
        red = green = blue = np.float32(0)
        for k in range(start[r], start[r + 1]):
            p = place[k]
            red += np.float32(steps[k, 0]) * light[p, 0]
            green += np.float32(steps[k, 1]) * light[p, 1]
            blue += np.float32(steps[k, 2]) * light[p, 2]
        red, green, blue = scale[r, 0] * red, scale[r, 1] * green, scale[r, 2] * blue
        for f in range(FACES):
            red += base[r, f, 0] * light[f * size, 0]
            green += base[r, f, 1] * light[f * size, 1]
            blue += base[r, f, 2] * light[f * size, 2]
        out[r, 0], out[r, 1], out[r, 2] = red, green, blue
