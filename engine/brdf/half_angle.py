"""Places of angles on a curve over the half angle: narrow bands where the angle is small."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray


def angle_of(u: NDArray[np.float64]) -> NDArray[np.float64]:
    """γ in radians of places u in [0, 1]: u⁴ = 1 - cos γ, so that small angles get most places."""
    return np.arccos(1 - u**4)


@njit
def place_of(cosine):
    """The inverse of `angle_of`, of cos γ."""
    return math.sqrt(math.sqrt(max(0.0, 1.0 - cosine)))
