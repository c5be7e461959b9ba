"""Directions that view samples look in, without knowing their BRDF.

`brdf_editing` (Ben-Artzi et al. 2008), §5.1: most follow the cosine, the others a Blinn-Phong lobe,
which is what lets near mirrors be edited. Both are rank-one lattices. Pixels of a block of 8 x 8
have lattices of their own, and blocks have the same, so that directions need not be stored: of each
ray only what it meets is. All rays together count as one sampler, with the density of both (balance
heuristic, Veach and Guibas 1995).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.base import half
from engine.methods.brdf_editing.settings import Settings
from engine.numerics.frames import to_world
from engine.numerics.sampling import cosine_hemisphere, cosine_power_hemisphere
from engine.numerics.vec import dot, reflect, vec

SIDE = 8
FAR = 25.0  # cosines from where on a lobe is e⁻²⁵ of its peak, or less
GOLDEN = 0.6180339887498949
PLASTIC = 0.7548776662466927, 0.5698402909980532  # powers of the inverse of the plastic number


class Patterns(NamedTuple):
    """The lattices.

    local     (64, N, 3) float64   the first `cosines` are incident directions, others half vectors
    cosines   int
    exponent  float                of the lobe
    """

    local: NDArray[np.float64]
    cosines: int
    exponent: float


def patterns(settings: Settings) -> Patterns:
    """Those of the settings."""
    count, cosines = settings.view_rays, settings.cosine_count
    local = np.zeros((SIDE * SIDE, count, 3))
    for number in range(SIDE * SIDE):
        shift1, shift2 = ((0.5 + (number + 1) * p) % 1.0 for p in PLASTIC)
        for k in range(count):
            lobe = k >= cosines
            n, i = (count - cosines, k - cosines) if lobe else (cosines, k)
            u1, u2 = (i + shift1) / n, (i * GOLDEN + shift2) % 1.0
            local[number, k] = (
                cosine_power_hemisphere.py_func(1 - u1, u2, settings.lobe_exponent)
                if lobe
                else cosine_hemisphere.py_func(u1, u2)
            )
    return Patterns(local, cosines, settings.lobe_exponent)


@njit
def pattern_of(pixel, width):
    """The lattice of a pixel: neighbours in a picture so wide have others."""
    x, y = pixel % width % SIDE, pixel // width % SIDE
    # Neighbours are far apart in the order of the lattices, which are alike if next to each other.
    return (x * 37 + y * 23) % (SIDE * SIDE)


@njit
def ray_of(patterns, pattern, k, wo, frame, geometric):
    """(local, world) incident direction of ray k; local z ≤ 0 where it does not leave the surface.

    frame is the tangent, bitangent and shading normal.
    """
    w = vec(patterns.local[pattern], k)
    if k >= patterns.cosines:
        w = reflect(wo, w) if dot(w, wo) > 0.0 else (0.0, 0.0, -1.0)
    d = to_world(w, frame[0], frame[1], frame[2])
    return w if dot(d, geometric) > 0.0 else (0.0, 0.0, -1.0), d


@njit
def weight_of(patterns, wi, wo):
    """cos θ_i over the density of all rays together, sr."""
    density = patterns.cosines * wi[2] / math.pi
    lobes = patterns.local.shape[1] - patterns.cosines
    if lobes > 0:
        h, cos_d = half(wi, wo)
        n = patterns.exponent
        # Powers take long; most directions are far from the lobe.
        if patterns.cosines == 0 or n * (1.0 - h[2]) < FAR:
            lobe = (n + 1.0) / (2.0 * math.pi) * min(1.0, h[2]) ** n
            density += lobes * lobe / max(1e-30, 4.0 * cos_d)
    return wi[2] / density
