"""Three-vectors as tuples of floats, for use inside Numba kernels.

A tuple lives in registers, so these functions cost nothing once inlined.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

Vec = tuple[float, float, float]


@njit
def vec(a, i):
    """Row `i` of an (n, 3) array as a tuple of float64.

    Numba's `float` leaves a float32 as it is, hence the explicit type.
    """
    return (np.float64(a[i, 0]), np.float64(a[i, 1]), np.float64(a[i, 2]))


@njit
def add(a, b):
    """a + b."""
    return (a[0] + b[0], a[1] + b[1], a[2] + b[2])


@njit
def sub(a, b):
    """a - b."""
    return (a[0] - b[0], a[1] - b[1], a[2] - b[2])


@njit
def mul(a, b):
    """Component-wise a * b, for colours."""
    return (a[0] * b[0], a[1] * b[1], a[2] * b[2])


@njit
def scale(a, s):
    """a * s for a number s."""
    return (a[0] * s, a[1] * s, a[2] * s)


@njit
def dot(a, b):
    """a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit
def cross(a, b):
    """a × b."""
    return (
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    )


@njit
def length(a):
    """|a|."""
    return math.sqrt(dot(a, a))


@njit
def normalize(a):
    """a / |a|; the zero vector stays zero."""
    n = length(a)
    if n == 0.0:
        return (0.0, 0.0, 0.0)
    return (a[0] / n, a[1] / n, a[2] / n)


@njit
def reflect(w, n):
    """Mirror of w about n, both leaving the surface."""
    k = 2.0 * dot(w, n)
    return (k * n[0] - w[0], k * n[1] - w[1], k * n[2] - w[2])
