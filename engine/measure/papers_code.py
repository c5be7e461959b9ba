"""The paper's own encoding of a BRDF, to measure ours against: Claustres, Barthe, Paulin 2007.

Of f̃ = log((f + εμ) / μ), μ the mean of all samples (§5.1), each incident direction's hemisphere of
outgoing ones is transformed by Haar's orthonormal wavelets, along θ, then φ, level by level (§4.2).
The coefficients of one wavelet, over all incident directions, are a slice. Slices of the least norm
are left out (§4.3); a map of 16-bit numbers says which are there, and all others are the slice 0 of
zeros (§5.2). The paper's table 1 counts slices of floats; of bytes (§5.1) four times as many fit.
It does not say how floats become bytes: here those of a depth of the tree share one even scale,
and the means have their own.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.brdf.wavelet.analysis import Array

STEPS = 127
ROOT2 = np.sqrt(2.0)


class PapersCode:
    """The transform of a table; `at` gives what is left of it in a number of bytes."""

    def __init__(self, values: NDArray[np.floating], floor: float) -> None:
        """values (θ, φ, down, across, 3) sr⁻¹, as many cells along θ as φ; floor is ε."""
        self._size = len(values)
        table = np.asarray(values, np.float64)
        self._mean = float(table.mean()) or 1.0
        self._floor = floor
        self._wavelets = forward(np.log(table / self._mean + floor))
        self._norm = np.sqrt((self._wavelets**2).sum(axis=(2, 3, 4))).ravel()
        self._norm[0] = np.inf  # the means are never left out
        self._order = np.argsort(-self._norm, kind="stable")

    def bytes_of(self, kept: int, octets: bool) -> int:
        """So many slices, and the map; slice 0, ranges and header are not counted."""
        slice_ = int(np.prod(self._wavelets.shape[2:])) * (1 if octets else 4)
        return kept * slice_ + 2 * len(self._order)

    def kept(self, size: int, octets: bool) -> int:
        """How many slices fit; at least the means do not, then it is 0."""
        room = size - self.bytes_of(0, octets)
        return min(
            len(self._order), max(0, room // (self.bytes_of(1, octets) - 2 * len(self._order)))
        )

    def at(self, kept: int, octets: bool) -> Array:
        """Values (θ, φ, down, across, 3) of the heaviest slices."""
        shape = self._wavelets.shape
        slices = np.zeros((shape[0] * shape[1], *shape[2:]))
        some = self._order[:kept]
        slices[some] = self._wavelets.reshape(slices.shape)[some]
        if octets:
            slices = self._rounded(slices)
        found = self._mean * (np.exp(backward(slices.reshape(shape))) - self._floor)
        return np.maximum(found, 0)

    def _rounded(self, slices: Array) -> Array:
        """To 8 bits, in even steps up to the largest of a depth."""
        i, j = np.indices((self._size, self._size)).reshape(2, -1)
        depth = np.frexp(np.maximum(i, j))[1]
        out = slices.copy()
        for k in range(depth.max() + 1):
            here = out[depth == k]
            step = (np.abs(here).max() or 1.0) / STEPS
            out[depth == k] = step * np.rint(here / step)
        return out


def forward(values: Array) -> Array:
    """Haar's transform over the first two axes, of equal length: means first, then details."""
    out, size = values.copy(), len(values)
    while size > 1:
        for axis in (0, 1):
            part = out[:size, :size].swapaxes(0, axis)
            low, high = (part[0::2] + part[1::2]) / ROOT2, (part[0::2] - part[1::2]) / ROOT2
            out[:size, :size] = np.concatenate([low, high]).swapaxes(0, axis)
        size //= 2
    return out


def backward(coefficients: Array) -> Array:
    """The inverse of `forward`."""
    out, size = coefficients.copy(), 2
    while size <= len(out):
        for axis in (1, 0):
            part = out[:size, :size].swapaxes(0, axis)
            low, high = part[: size // 2], part[size // 2 :]
            pair = np.stack([(low + high) / ROOT2, (low - high) / ROOT2], axis=1)
            out[:size, :size] = pair.reshape(part.shape).swapaxes(0, axis)
        size *= 2
    return out
