"""Importance sampling from the tree of an encoded BRDF.

Measured data are reciprocal (or made so), so the tree may as well hold the incident directions and
the plane the outgoing one. Going down by the odds of the halves finds a cell with a chance that is
the light it reflects, cosine and all; around its centre the direction then falls off linearly to
the next, so that the density is as smooth as the values are. What is sampled is the luminance.
"""

from __future__ import annotations

import math

from numba import njit

from engine.brdf.base import luminance
from engine.brdf.wavelet.layout import (
    GENERAL,
    ISOTROPIC,
    ORTHOTROPIC,
    PHI_BITS,
    SYMMETRY,
    THETA_BITS,
)
from engine.brdf.wavelet.synthesis import (
    SCRATCH,
    around,
    halve,
    mirrored,
    plane_taps,
    root_at,
    split_below,
    tile_places,
    turned,
)
from engine.numerics.lanes import COUNT
from engine.numerics.memory import int32_at, load_float, stack_words
from engine.numerics.tangent_poles import direction


@njit(error_model="numpy")
def _luminance(reflected, depth):
    """Of what a cell reflects."""
    p = COUNT * depth
    return luminance(
        (load_float(reflected, p), load_float(reflected, p + 1), load_float(reflected, p + 2))
    )


@njit(error_model="numpy")
def _whole(a, plane):
    """Luminance that all of the images of the tree reflect."""
    room = stack_words(COUNT)
    total = 0.0
    for image in range(_images(a)):
        root_at(a, plane_taps(a, mirrored(plane, image)), room)
        total += _luminance(room, 0)
    return total


@njit(error_model="numpy")
def _images(a):
    return 4 if int32_at(a, SYMMETRY) == ORTHOTROPIC else 1


@njit(error_model="numpy")
def pdf(a, wi, wo):
    """Density of `sample` over solid angle; both directions above the surface."""
    plane, tree = turned(a, wo, wi)
    # `turned` mirrors the plane with the tree, which changes none of what all images reflect.
    reflected = luminance(around(a, plane, tree, 0, False)) / _whole(a, plane)
    sine = math.sqrt(tree[0] * tree[0] + tree[2] * tree[2])
    return reflected * _cells_per_angle(a) / max(1e-30, sine)


@njit(error_model="numpy")
def _cells_per_angle(a):
    """Cells per dθ dφ, of the hemisphere as a whole: a mirrored tree is as often there."""
    cells = float(1 << (int32_at(a, THETA_BITS) + int32_at(a, PHI_BITS)))
    symmetry = int32_at(a, SYMMETRY)
    # An image of the isotropic tree is taken every other time.
    return cells * (4.0 if symmetry == ORTHOTROPIC else 1.0) / (math.pi * math.pi)


@njit(error_model="numpy")
def sample(a, wo, u):
    """An incident direction for wo above the surface; u three numbers in [0, 1)."""
    symmetry = int32_at(a, SYMMETRY)
    plane, x_axis = wo, (1.0, 0.0)
    if symmetry == ISOTROPIC:
        r = math.sqrt(wo[0] * wo[0] + wo[1] * wo[1])
        if r > 1e-12:
            x_axis = wo[0] / r, wo[1] / r
        plane = (r, 0.0, wo[2])
    reflected = stack_words(SCRATCH)
    # Choose an image by what it reflects.
    left, chosen, rest = u[2] * _whole(a, plane), 0, 0.5
    for image in range(_images(a)):
        root_at(a, plane_taps(a, mirrored(plane, image)), reflected)
        part = _luminance(reflected, 0)
        if left >= 0.0:
            chosen, rest = image, left / part
        left -= part
    taps = plane_taps(a, mirrored(plane, chosen))
    root_at(a, taps, reflected)
    places = tile_places(a, taps)
    # Down the tree, either number used up by the splits of one angle.
    i, j, node, p, q = 0, 0, 1, u[0], u[1]
    theta_bits, phi_bits = int32_at(a, THETA_BITS), int32_at(a, PHI_BITS)
    for k in range(theta_bits + phi_bits):
        cuts_theta, ratio = split_below(a, k, i, j)
        halve(a, node, k, ratio, False, taps, places, reflected)
        first = min(1.0, _luminance(reflected, k + 1) / _luminance(reflected, k))
        r = p if cuts_theta else q
        second = 1 if r >= first else 0
        r = (r - first) / max(1e-30, 1.0 - first) if second else r / max(1e-30, first)
        if second:
            halve(a, node, k, ratio, True, taps, places, reflected)
        if cuts_theta:
            i, p = 2 * i + second, r
        else:
            j, q = 2 * j + second, r
        node = 2 * node + second
    x, y = (i + _tent(p) + 0.5) / (1 << theta_bits), (j + _tent(q) + 0.5) / (1 << phi_bits)
    # At the horizon what falls beyond comes back; at a mirror it goes on behind it.
    x, y = abs(x), abs(y)
    if symmetry == ORTHOTROPIC:
        x *= 0.5
    elif x > 1.0:
        x = 2.0 - x
    if symmetry != GENERAL:
        y *= 0.5
    elif y > 1.0:
        y = 2.0 - y
    w = mirrored(direction(x, y), chosen)
    if symmetry == ISOTROPIC:
        side = 1.0 if rest < 0.5 else -1.0
        w = (w[0], side * w[1], w[2])
        w = (x_axis[0] * w[0] - x_axis[1] * w[1], x_axis[1] * w[0] + x_axis[0] * w[1], w[2])
    return w


@njit(error_model="numpy")
def _tent(u):
    """A number in (-1, 1) with density 1 - |x|."""
    return math.sqrt(2.0 * u) - 1.0 if u < 0.5 else 1.0 - math.sqrt(2.0 * (1.0 - u))
