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
from engine.numerics.sampling import cosine_hemisphere, cosine_power_hemisphere
from engine.numerics.vec import dot, reflect

SIDE = 8
FAR = 25.0  # a lobe's density is e⁻²⁵ of its peak at least
GOLDEN = 0.6180339887498949
PLASTIC = 0.7548776662466927, 0.5698402909980532  # powers of the inverse of the plastic number


class Patterns(NamedTuple):
    """The lattices.

    local     (64, 3, N) float64   the first `cosines` are incident directions, others half vectors
    cosines   int
    exponent  int                  of the lobe
    """

    local: NDArray[np.float64]
    cosines: int
    exponent: int


class Rays(NamedTuple):
    """Rays of a pixel or of a part of one, (N,) float64 each.

    x, y, z      local incident directions; z is negative where a ray does not leave the surface
    weight       cos θ_i over the density of all rays together, sr; 0 for those
    lobe, power  room for what that is made of
    """

    x: NDArray[np.float64]
    y: NDArray[np.float64]
    z: NDArray[np.float64]
    weight: NDArray[np.float64]
    lobe: NDArray[np.float64]
    power: NDArray[np.float64]


def patterns(settings: Settings) -> Patterns:
    """Those of the settings."""
    count, cosines = settings.view_rays, settings.cosine_count
    local, exponent = np.zeros((SIDE * SIDE, 3, count)), settings.lobe_exponent
    for number in range(SIDE * SIDE):
        shift1, shift2 = ((0.5 + (number + 1) * p) % 1.0 for p in PLASTIC)
        for k in range(count):
            lobe = k >= cosines
            n, i = (count - cosines, k - cosines) if lobe else (cosines, k)
            u1, u2 = (i + shift1) / n, (i * GOLDEN + shift2) % 1.0
            local[number, :, k] = (
                cosine_power_hemisphere.py_func(1 - u1, u2, exponent)
                if lobe
                else cosine_hemisphere.py_func(u1, u2)
            )
    return Patterns(local, cosines, exponent)


@njit
def room_for(count):
    """`Rays` that hold so many."""
    room = np.zeros((6, count))
    return Rays(room[0], room[1], room[2], room[3], room[4], room[5])


@njit
def pattern_of(pixel, width):
    """The lattice of a pixel: neighbours in a picture so wide have others."""
    x, y = pixel % width % SIDE, pixel // width % SIDE
    # Neighbours are far apart in the order of the lattices, which are alike if next to each other.
    return (x * 37 + y * 23) % (SIDE * SIDE)


@njit(fastmath={"contract", "reassoc"}, error_model="numpy")
def rays_of(patterns, pattern, part, parts, wo, g, rays):
    """Fill `rays` with every parts-th one of a lattice, and return how many there are.

    wo and the geometric normal g are local.
    """
    local = patterns.local[pattern]
    x, y, z, weight, lobe, power = rays
    count = (local.shape[1] - part + parts - 1) // parts
    first = max(0, patterns.cosines - part + parts - 1) // parts
    for q in range(first):
        k = part + q * parts
        x[q], y[q], z[q] = local[0, k], local[1, k], local[2, k]
    for q in range(first, count):
        k = part + q * parts
        h = (local[0, k], local[1, k], local[2, k])
        w = reflect(wo, h)
        x[q], y[q] = w[0], w[1]
        z[q] = w[2] if dot(wo, h) > 0.0 else -1.0
    for q in range(count):
        z[q] = z[q] if dot((x[q], y[q], z[q]), g) > 0.0 else -1.0
    _lobe_density(patterns, wo, count, x, y, z, lobe, power)
    for q in range(count):
        cosine = max(0.0, z[q])
        density = patterns.cosines * cosine / math.pi + lobe[q]
        weight[q] = cosine / max(1e-30, density)
    return count


@njit(fastmath={"contract", "reassoc"}, error_model="numpy")
def _lobe_density(patterns, wo, count, x, y, z, lobe, power):
    """Fill `lobe` with the density of the rays that follow one."""
    lobes, n = patterns.local.shape[2] - patterns.cosines, patterns.exponent
    least, unit = math.exp(-FAR / n), lobes * (n + 1) / (8.0 * math.pi)
    for q in range(count):
        h, cos_d = half((x[q], y[q], z[q]), wo)
        power[q] = min(1.0, max(least, h[2]))
        lobe[q] = unit / max(1e-30, cos_d)
    # Powers by squares, for all rays at once.
    while n > 0:
        if n % 2 == 1:
            for q in range(count):
                lobe[q] *= power[q]
        n //= 2
        for q in range(count):
            power[q] *= power[q]
