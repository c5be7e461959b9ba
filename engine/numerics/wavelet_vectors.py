"""Cube-map vectors in the Haar basis, all but the largest coefficients left out, in eight bits.

`glossy_prt` (Wang, Tran, Luebke 2006) §4.1.1, §4.1.2. Coefficients are orthonormal, so that the
largest are the best to keep. The six scaling coefficients, one of each face, are always kept, and
exactly: they are up to a hundred times the others, which have a scale of their own. Coefficients
that eight bits cannot tell from 0 are left out, so that a plain vector is a short one.

The channels of a vector share their places, as the terms of a vertex have their shadows in common:
that takes half the bytes of the paper's list for every term, and a light's coefficient is fetched
once for all of them. A place below 24,576 (6 x 64 x 64) fits the paper's block of 256 and offset
within it: 16 bits.
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics import haar
from engine.numerics.cube_map import FACES, solid_angles
from engine.numerics.parallel import for_ranges

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


def before(count: NDArray[np.integer]) -> NDArray[np.int64]:
    """How many there are before each, of so many each: where runs behind each other begin."""
    return np.concatenate([[0], np.cumsum(count)[:-1]]).astype(np.int64)


class Room(NamedTuple):
    """Where `keep_largest` writes r vectors: length, base and scale as of `WaveletVectors`, place
    (r, most) and steps (r, most, c).
    """

    length: NDArray[np.int32]
    base: NDArray[np.float32]
    scale: NDArray[np.float32]
    place: NDArray[np.uint16]
    steps: NDArray[np.int8]

    def packed(self) -> WaveletVectors:
        """The vectors that were written."""
        kept = np.arange(self.place.shape[1]) < self.length[:, None]
        return WaveletVectors(*self[:3], self.place[kept], self.steps[kept])


def room_for(rows: int, most: int, channels: int) -> Room:
    """Room for so many vectors of at most so many places."""
    return Room(
        np.zeros(rows, np.int32),
        np.zeros((rows, FACES, channels), np.float32),
        np.zeros((rows, channels), np.float32),
        np.zeros((rows, most), np.uint16),
        np.zeros((rows, most, channels), np.int8),
    )


@njit(cache=True)
def to_haar(texels):
    """Haar coefficients of a cube map (6 n², c), in place; a face that is black is passed over."""
    size = texels.shape[0] // FACES
    for f in range(FACES):
        face = texels[f * size : (f + 1) * size]
        if face.any():
            face[:] = haar.transform(face)


@njit
def keep_largest(values, white, weight, most, tolerance, base, scale, place, steps):
    """Keep at most `most` places of a vector (6 n², c), the scaling ones among them.

    weight (c,) float32 tells how much the channels count against each other. Fewer are kept where
    what is left out is no more than the part `tolerance` of the vector's norm. The product with
    white (6 n²,), see `white_light`, is kept as it was by a change of the scaling coefficients.
    Fills base (6, c), scale (c,) and the first entries of place (most,) and steps (most, c);
    returns how many those are. `values` is used up.
    """
    size, channels = values.shape[0] // FACES, values.shape[1]
    whole, lack = 0.0, np.zeros(channels)
    for f in range(FACES):
        for c in range(channels):
            base[f, c] = values[f * size, c]
            whole += (weight[c] * values[f * size, c]) ** 2
            values[f * size, c] = 0.0
    # Most of a vector is nothing at all.
    here, count = np.zeros(values.shape[0], np.int32), 0
    for i in range(values.shape[0]):
        for c in range(channels):
            if values[i, c] != 0.0:
                here[count] = i
                count += 1
                break
    scale[:] = 0.0
    for j in range(count):
        i = here[j]
        for c in range(channels):
            lack[c] += white[i] * values[i, c]
            scale[c] = max(scale[c], abs(values[i, c]))
    scale /= STEPS
    # Candidates, and the power that one must have to be among the largest.
    power, lost = np.zeros(count, np.float32), 0.0
    there, count = count, 0
    for j in range(there):
        i, total, told = here[j], np.float32(0), False
        for c in range(channels):
            value = values[i, c]
            told |= abs(value) > 0.5 * scale[c]
            total += (weight[c] * value) * (weight[c] * value)
        whole += total
        if told:
            power[count], here[count] = total, i
            count += 1
        else:
            lost += total
    room = most - FACES
    least = max(0, count - room)
    # What there is no room for need not be in order.
    parted = np.partition(power[:count], min(least, count - 1)) if least else power[:count]
    for j in range(least):
        lost += parted[j]
    ranked = np.sort(parted[least:])
    least = 0
    while least < len(ranked) and lost + ranked[least] <= tolerance * tolerance * whole:
        lost += ranked[least]
        least += 1
    bar = ranked[least] if least < len(ranked) else np.float32(np.inf)
    room = len(ranked) - least
    kept = 0
    for j in range(count):
        if power[j] >= bar and kept < room:
            place[kept] = here[j]
            for c in range(channels):
                step = scale[c]
                steps[kept, c] = np.int8(round(values[here[j], c] / step)) if step > 0.0 else 0
                lack[c] -= white[here[j]] * step * steps[kept, c]
            kept += 1
    for c in range(channels):
        size_of = 0.0
        for f in range(FACES):
            size_of += white[f * size] * abs(base[f, c])
        if size_of > 0.0:
            for f in range(FACES):
                base[f, c] += lack[c] / size_of * abs(base[f, c])
    return kept


@cache
def white_light(n: int) -> NDArray[np.float32]:
    """(6 n²,): Haar coefficients of light of radiance 1 from everywhere, times solid angle."""
    texels = solid_angles(n)[:, None].astype(np.float32)
    to_haar(texels)
    return np.ascontiguousarray(texels[:, 0])


def added(
    a: WaveletVectors,
    b: WaveletVectors,
    weight: NDArray[np.float32],
    most: int,
    tolerance: float,
    n: int,
) -> WaveletVectors:
    """The sums of vectors of the same channels, on cube maps of n x n texels a face."""
    rows, channels = a.scale.shape
    room = room_for(rows, most, channels)
    for_ranges(
        _add_pairs, rows, a.start, *a[1:], b.start, *b[1:], white_light(n),
        weight, most, tolerance, *room, grain=256,
    )  # fmt: skip
    return room.packed()


def shortened(
    vectors: WaveletVectors, weight: NDArray[np.float32], most: int, tolerance: float, n: int
) -> WaveletVectors:
    """The vectors with no more than `most` places, on cube maps of n x n texels a face."""
    nothing = room_for(len(vectors.length), 0, vectors.scale.shape[1]).packed()
    return added(vectors, nothing, weight, most, tolerance, n)


@njit(cache=True, nogil=True)
def _add_pairs(
    begin, end, a_start, a_base, a_scale, a_place, a_steps,
    b_start, b_base, b_scale, b_place, b_steps, white,
    weight, most, tolerance, length, base, scale, place, steps,
):  # fmt: skip
    values = np.zeros((len(white), scale.shape[1]), np.float32)
    for i in range(begin, end):
        values[:] = 0.0
        spread(a_start, a_base, a_scale, a_place, a_steps, i, values)
        spread(b_start, b_base, b_scale, b_place, b_steps, i, values)
        length[i] = keep_largest(
            values, white, weight, most, tolerance, base[i], scale[i], place[i], steps[i]
        )


@njit
def spread(start, base, scale, place, steps, i, values):
    """Add the coefficients of vector i to values (6 n², c)."""
    size = values.shape[0] // FACES
    for k in range(start[i], start[i + 1]):
        for c in range(values.shape[1]):
            values[place[k], c] += scale[i, c] * np.float32(steps[k, c])
    for f in range(FACES):
        for c in range(values.shape[1]):
            values[f * size, c] += base[i, f, c]


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
