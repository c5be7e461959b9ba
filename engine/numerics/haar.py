"""The two-dimensional Haar transform of arrays that are stored in quad-tree order.

A power-of-four array is laid out so that every block of a 2^k x 2^k image is a run of 4^k
consecutive numbers: the children of node i of one level are nodes 4i..4i+3 of the next. A cluster
hierarchy has that order by construction, an image after sorting by Morton code. The basis is
orthonormal. Coefficient 0 is the scaling coefficient; node i of level l (4^l nodes) owns the three
coefficients 4^l + 3i + (0, 1, 2):

    scaling     (a + b + c + d) / 2
    horizontal  (a - b + c - d) / 2
    vertical    (a + b - c - d) / 2
    diagonal    (a - b - c + d) / 2
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray


def levels(n: int) -> int:
    """The k of n = 4^k; raises ValueError where n is no power of four."""
    k = (n.bit_length() - 1) // 2
    if n < 1 or 4**k != n:
        raise ValueError(f"{n} is not a power of four")
    return k


def forward(values: NDArray[np.float32]) -> NDArray[np.float32]:
    """Coefficients (n, c) float32 of values (n, c) float32 in quad-tree order."""
    levels(len(values))
    out: NDArray[np.float32] = transform(np.ascontiguousarray(values))
    return out


def inverse(coefficients: NDArray[np.float32]) -> NDArray[np.float32]:
    """Values (n, c) float32 of coefficients (n, c) float32."""
    levels(len(coefficients))
    out: NDArray[np.float32] = restore(np.ascontiguousarray(coefficients))
    return out


@njit(cache=True, nogil=True)
def transform(values):
    """`forward` within a kernel, of a contiguous array."""
    n, channels = values.shape
    out = np.zeros_like(values)
    scaling = values
    while n > 1:
        n //= 4
        parents = np.zeros((n, channels), values.dtype)
        _analyse(scaling, parents, out[n : 4 * n])
        scaling = parents
    out[0] = scaling[0]
    return out


@njit(cache=True, nogil=True)
def restore(coefficients):
    """`inverse` within a kernel, of a contiguous array."""
    scaling = coefficients[:1].copy()
    n = 1
    while n < coefficients.shape[0]:
        children = np.zeros((4 * n, coefficients.shape[1]), coefficients.dtype)
        _synthesise(scaling, coefficients[n : 4 * n], children)
        scaling = children
        n *= 4
    return scaling


@njit(nogil=True)
def _analyse(children, parents, details):
    for i in range(parents.shape[0]):
        for c in range(parents.shape[1]):
            v0, v1 = children[4 * i, c], children[4 * i + 1, c]
            v2, v3 = children[4 * i + 2, c], children[4 * i + 3, c]
            parents[i, c] = 0.5 * (v0 + v1 + v2 + v3)
            details[3 * i, c] = 0.5 * (v0 - v1 + v2 - v3)
            details[3 * i + 1, c] = 0.5 * (v0 + v1 - v2 - v3)
            details[3 * i + 2, c] = 0.5 * (v0 - v1 - v2 + v3)


@njit(nogil=True)
def _synthesise(parents, details, children):
    for i in range(parents.shape[0]):
        for c in range(parents.shape[1]):
            s, h = parents[i, c], details[3 * i, c]
            v, d = details[3 * i + 1, c], details[3 * i + 2, c]
            children[4 * i, c] = 0.5 * (s + h + v + d)
            children[4 * i + 1, c] = 0.5 * (s - h + v - d)
            children[4 * i + 2, c] = 0.5 * (s + h - v - d)
            children[4 * i + 3, c] = 0.5 * (s - h - v + d)
