"""The product of packed rows with a light in wavelet space.

Row by row, all wavelets. Tried and left out, with dense tiles in the Cornell box and the living
room: culling wavelets whose light times their greatest coefficient is small (§3.5 of Hašan et al.
2006) costs more than it saves until a fifth of them is left, which is off by 2 to 3 % (at 0.15 % a
half is left, in 1.5 to 2.5 times the time: reading on is faster than choosing). The image-based
product of §4.4, a block of 8 x 8 pixels at a time, takes 2 to 2.7 times as long without culling and
1.2 to 1.7 times with culling at 0.15 %.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics import haar
from engine.numerics.packed import STEPS, TILE, step_units
from engine.numerics.parallel import for_ranges

restore = haar.restore
UNIT_OF = step_units()


def multiply(
    length: NDArray[np.int32],
    ids: NDArray[np.int32],
    mean: NDArray[np.float32],
    scale: NDArray[np.float32],
    steps: NDArray[np.int8],
    light: NDArray[np.float32],
    places: NDArray[np.int32],
    n: int,
) -> NDArray[np.float32]:
    """Matrix times light, (n, 3) float32, each row of the matrix at its place in it.

    length (tiles, 4), ids, mean (q,), scale (s,), steps (bytes,) are a `PackedRows`; light (n_g, 3)
    float32 Haar coefficients. places (tiles, 64 or 16) int32 hold a row of the result for every row
    of a tile, or for every fourth; -1 for a row that is not wanted.
    """
    first, start, stepped = (
        np.concatenate([[0], np.cumsum(count)])
        for count in (length.sum(axis=1), length @ STEPS, length[:, :-1].sum(axis=1))
    )
    out = np.zeros((n, 3), np.float32)
    args = (
        first, start, stepped, length, ids, mean, scale, steps, np.ascontiguousarray(light),
        places, out,
    )  # fmt: skip
    for_ranges(_multiply_tiles, len(length), *args, grain=16)
    return out


def _adder(width: int) -> Any:
    """Adds `count` wavelets of so many steps, from the k-th on, to the sums of a tile.

    The width is a constant in it, so that the inner loop becomes a few vector instructions. Four
    wavelets at a time make one pass over the sums, which took two thirds of the time of one by one.
    """

    @njit(inline="always")
    def add(k, count, s, z, ids, scale, steps, light, red, green, blue):
        end = k + count
        for j in range(k, end, 4):
            # Past the end of the list: its last wavelet again, with no light.
            j1, j2, j3 = min(j + 1, end - 1), min(j + 2, end - 1), min(j + 3, end - 1)
            r0, g0, b0 = _lit(ids[j], scale[z + j], light)
            r1, g1, b1 = _lit(ids[j1], scale[z + j1] * (j1 == j + 1), light)
            r2, g2, b2 = _lit(ids[j2], scale[z + j2] * (j2 == j + 2), light)
            r3, g3, b3 = _lit(ids[j3], scale[z + j3] * (j3 == j + 3), light)
            w0, w1 = _from(steps, s, j - k, width), _from(steps, s, j1 - k, width)
            w2, w3 = _from(steps, s, j2 - k, width), _from(steps, s, j3 - k, width)
            for p in range(width):
                x0, x1 = np.float32(w0[p]), np.float32(w1[p])
                x2, x3 = np.float32(w2[p]), np.float32(w3[p])
                red[p] += x0 * r0 + x1 * r1 + x2 * r2 + x3 * r3
                green[p] += x0 * g0 + x1 * g1 + x2 * g2 + x3 * g3
                blue[p] += x0 * b0 + x1 * b1 + x2 * b2 + x3 * b3

    return add


@njit(inline="always")
def _lit(wavelet, scale, light):
    step = np.float32(scale)
    return step * light[wavelet, 0], step * light[wavelet, 1], step * light[wavelet, 2]


@njit(inline="always")
def _from(steps, start, number, width):
    # A view, so that the inner loop's index is plainly in range: else it would not be vectorised.
    return steps[start + number * width : start + (number + 1) * width]


_add64, _add16, _add4 = (_adder(width) for width in STEPS[:3])


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _multiply_tiles(
    start, stop, first, begin, stepped, length, ids, mean, scale, steps, light, places, out
):  # fmt: skip
    red, green, blue = np.zeros((3, TILE), np.float32)
    sums = np.zeros((TILE, 3), np.float32)
    stride = TILE // places.shape[1]
    for t in range(start, stop):
        red[:] = 0
        green[:] = 0
        blue[:] = 0
        for k in range(first[t], first[t + 1]):
            r, g, b = _lit(ids[k], mean[k], light)
            red[0] += r
            green[0] += g
            blue[0] += b
        k, s = first[t], begin[t]
        z = stepped[t] - k  # from a wavelet's place to that of its scale
        n64, n16, n4 = length[t, 0], length[t, 1], length[t, 2]
        _add64(k, n64, s, z, ids, scale, steps, light, red, green, blue)
        k, s = k + n64, s + 64 * n64
        _add16(k, n16, s, z, ids, scale, steps, light, red, green, blue)
        k, s = k + n16, s + 16 * n16
        _add4(k, n4, s, z, ids, scale, steps, light, red, green, blue)

        # From what the tile has in common to its rows.
        for q in range(TILE):
            unit = UNIT_OF[q]
            sums[q, 0], sums[q, 1], sums[q, 2] = unit * red[q], unit * green[q], unit * blue[q]
        rows = restore(sums)
        for p in range(places.shape[1]):
            i = places[t, p]
            if i >= 0:
                for c in range(3):
                    out[i, c] = rows[p * stride, c]
