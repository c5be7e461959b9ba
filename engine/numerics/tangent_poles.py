"""The upper hemisphere as a square, with the poles of its coordinates along the tangent.

Claustres, Barthe, Paulin 2007, *Wavelet Encoding of BRDFs for Real-Time Rendering*, §4.1, of local
directions with z along the normal and y along the tangent that holds the poles:

    w = (sin φ cos θ, cos φ, sin φ sin θ),   θ and φ in [0, π]

So both angles have one range, no cell lies below the horizon, and where cells crowd is the horizon.
With dω = sin φ dθ dφ, the projected solid angle is z dω = sin θ dθ · sin² φ dφ: a product.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.numerics.angles import angle_over_sine
from engine.numerics.dispatch import formula


@formula
def _turn(y, x):
    """The angle of (x, y) for y ≥ 0, in halves of a turn."""
    r = math.sqrt(x * x + y * y)
    if r <= 0.0:
        return 0.5
    unit = 1.0 / r
    part = y * unit * angle_over_sine(abs(x) * unit) * (1.0 / math.pi)
    return part if x >= 0.0 else 1.0 - part


@formula
def coordinates(w):
    """(θ, φ) / π of a direction with z ≥ 0, both in [0, 1]."""
    return _turn(w[2], w[0]), _turn(math.sqrt(w[0] * w[0] + w[2] * w[2]), w[1])


@formula
def direction(u, v):
    """The unit direction at (θ, φ) = π (u, v)."""
    theta, phi = math.pi * u, math.pi * v
    s = math.sin(phi)
    return (s * math.cos(theta), math.cos(phi), s * math.sin(theta))


def directions(u: NDArray[np.float64], v: NDArray[np.float64]) -> NDArray[np.float64]:
    """(..., 3) of coordinates that broadcast against each other, in halves of a turn."""
    theta, phi = np.pi * u, np.pi * v
    s = np.sin(phi)
    return np.stack(
        np.broadcast_arrays(s * np.cos(theta), np.cos(phi) + 0 * s, s * np.sin(theta)), axis=-1
    )


def theta_weights(count: int, to: float = 1.0) -> NDArray[np.float64]:
    """(count,): ∫ sin θ dθ over as many equal parts of [0, π to]."""
    edge = np.linspace(0, np.pi * to, count + 1)
    # A difference of cosines has few digits where cells are narrow.
    middle, half = 0.5 * (edge[1:] + edge[:-1]), 0.5 * (edge[1:] - edge[:-1])
    return 2 * np.sin(middle) * np.sin(half)


def phi_weights(count: int, to: float = 1.0) -> NDArray[np.float64]:
    """(count,): ∫ sin² φ dφ over as many equal parts of [0, π to]."""
    edge = np.linspace(0, np.pi * to, count + 1)
    middle, half = 0.5 * (edge[1:] + edge[:-1]), 0.5 * (edge[1:] - edge[:-1])
    return half - 0.5 * np.cos(2 * middle) * np.sin(2 * half)
