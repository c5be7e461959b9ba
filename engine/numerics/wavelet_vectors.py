"""Cube-map vectors in the Haar basis, all but the largest coefficients left out, in eight bits.

`glossy_prt` (Wang, Tran, Luebke 2006) §4.1.1, §4.1.2. Coefficients are orthonormal, so that the
largest are the best to keep. The six scaling coefficients, one of each face, are always kept, and
exactly: they are up to a hundred times the others, which have a scale of their own. A coefficient
that eight bits cannot tell from 0 is left out, so that a plain vector is a short one.

A place below 24,576 (6 x 64 x 64) fits the paper's block of 256 and offset within it: 16 bits.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics import haar
from engine.numerics.cube_map import FACES

STEPS = 127  # the largest coefficient of a vector


class WaveletVectors(NamedTuple):
    """r vectors of c channels.

    length   (r,) int32          how many coefficients each has beside the scaling ones
    base     (r, 6, c) float32   the scaling ones
    scale    (r, c) float32      what a step is
    place    (q,) uint16         of the others, vector after vector, ascending
    steps    (q, c) int8         their values in steps
    """

    length: NDArray[np.int32]
    base: NDArray[np.float32]
    scale: NDArray[np.float32]
    place: NDArray[np.uint16]
    steps: NDArray[np.int8]

    @property
    def start(self) -> NDArray[np.int64]:
        """(r + 1,): where the coefficients of each begin, and the end."""
        return np.concatenate([[0], np.cumsum(self.length, dtype=np.int64)])


@njit
def to_haar(texels):
    """Haar coefficients of a cube map (6 n², c), in place; a face that is black is passed over."""
    size = texels.shape[0] // FACES
    for f in range(FACES):
        face = texels[f * size : (f + 1) * size]
        if face.any():
            face[:] = haar.transform(face)


@njit
def keep_largest(values, most, base, scale, place, steps):
    """Keep at most `most` coefficients of a vector (6 n², c), the scaling ones among them.

    Fills base (6, c), scale (c,) and the first entries of place (most,) and steps (most, c);
    returns how many those are. `values` is used up.
    """
    size, channels = values.shape[0] // FACES, values.shape[1]
    for f in range(FACES):
        for c in range(channels):
            base[f, c] = values[f * size, c]
            values[f * size, c] = 0.0
    largest = 0.0
    for c in range(channels):
        top = 0.0
        for i in range(values.shape[0]):
            top = max(top, abs(values[i, c]))
        scale[c] = top / STEPS
        largest = max(largest, top)
    # Candidates, and the square that one must have to be among the largest.
    floor = (0.5 * largest / STEPS) ** 2
    count, bar = 0, floor
    square = np.zeros(values.shape[0], np.float32)
    for i in range(values.shape[0]):
        power = np.float32(0)
        for c in range(channels):
            power += values[i, c] * values[i, c]
        if power > floor:
            square[count] = power
            count += 1
    room = most - FACES
    if count > room:
        bar = np.partition(square[:count], count - room)[count - room] if room > 0 else np.inf
    kept = 0
    for i in range(values.shape[0]):
        power = np.float32(0)
        for c in range(channels):
            power += values[i, c] * values[i, c]
        if power > floor and power >= bar and kept < room:
            place[kept] = i
            for c in range(channels):
                step = scale[c]
                steps[kept, c] = np.int8(round(values[i, c] / step)) if step > 0.0 else 0
            kept += 1
    return kept


def dense(vectors: WaveletVectors, n: int) -> NDArray[np.float32]:
    """The vectors as cube maps of n x n texels a face, (r, 6 n², c) float32."""
    size, channels = n * n, vectors.base.shape[2]
    out = np.zeros((len(vectors.length), FACES * size, channels), np.float32)
    row = np.repeat(np.arange(len(vectors.length)), vectors.length)
    out[row, vectors.place] = vectors.steps * vectors.scale[row]
    out[:, ::size] = vectors.base
    for values in out:
        for f in range(FACES):
            values[f * size : (f + 1) * size] = haar.inverse(values[f * size : (f + 1) * size])
    return out
