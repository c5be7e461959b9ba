"""Random numbers and the warps of the unit square that every integrator shares.

Densities are with respect to solid angle unless said otherwise. The generator is counter-based:
the same (seed, index, dimension) gives the same number on every machine and in every order of
work, which is what makes renders reproducible however the work is cut.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

_M1 = np.uint64(0xBF58476D1CE4E5B9)
_M2 = np.uint64(0x94D049BB133111EB)
_GOLDEN = np.uint64(0x9E3779B97F4A7C15)


@njit
def _mix(z):
    z = (z ^ (z >> np.uint64(30))) * _M1
    z = (z ^ (z >> np.uint64(27))) * _M2
    return z ^ (z >> np.uint64(31))


@njit
def uniform(seed, index, dimension):
    """A number in [0, 1), a pure function of its three integer arguments (SplitMix64 finaliser)."""
    z = _mix(np.uint64(seed) * _GOLDEN + np.uint64(index))
    z = _mix(z + np.uint64(dimension) * _GOLDEN + _GOLDEN)
    return float(z >> np.uint64(40)) * 5.9604644775390625e-08  # 2^-24


@njit
def concentric_disk(u1, u2):
    """A point of the unit disk, evenly; neighbours on the square are neighbours on the disk.

    Concentric squares become concentric circles (Shirley and Chiu 1997).
    """
    a, b = 2.0 * u1 - 1.0, 2.0 * u2 - 1.0
    if a == 0.0 and b == 0.0:
        return (0.0, 0.0)
    if abs(a) > abs(b):
        phi = 0.25 * math.pi * b / a
        return (a * math.cos(phi), a * math.sin(phi))
    phi = 0.25 * math.pi * a / b
    return (b * math.sin(phi), b * math.cos(phi))


@njit
def uniform_cone(u1, u2, versine):
    """Direction about z within the cone of 1 - cos θ = versine, with density 1 / (2π versine).

    Neighbours on the square are neighbours on the cone.
    """
    a, b = concentric_disk(u1, u2)
    # The height above the rim's plane grows evenly with the area of the disk.
    drop = versine * (a * a + b * b)
    k = math.sqrt(versine * (2.0 - drop))
    return (a * k, b * k, 1.0 - drop)


@njit
def cosine_hemisphere(u1, u2):
    """Direction about z with density cos θ / π."""
    r = math.sqrt(u1)
    phi = 2.0 * math.pi * u2
    return (r * math.cos(phi), r * math.sin(phi), math.sqrt(max(0.0, 1.0 - u1)))


@njit
def cosine_power_hemisphere(u1, u2, exponent):
    """Direction about z with density (exponent + 1) / 2π · cos^exponent θ."""
    z = u1 ** (1.0 / (exponent + 1.0))
    r = math.sqrt(max(0.0, 1.0 - z * z))
    phi = 2.0 * math.pi * u2
    return (r * math.cos(phi), r * math.sin(phi), z)


@njit
def uniform_sphere(u1, u2):
    """Direction with density 1 / 4π."""
    z = 1.0 - 2.0 * u1
    r = math.sqrt(max(0.0, 1.0 - z * z))
    phi = 2.0 * math.pi * u2
    return (r * math.cos(phi), r * math.sin(phi), z)


@njit
def uniform_triangle(u1, u2):
    """Barycentrics (b1, b2) uniform over a triangle; the first vertex weighs 1 - b1 - b2."""
    s = math.sqrt(u1)
    return (s * (1.0 - u2), s * u2)


@njit
def balance(a, b):
    """Balance heuristic a / (a + b) (Veach 1997, eq. 9.8); 0 where both vanish."""
    return a / (a + b) if a + b > 0.0 else 0.0
