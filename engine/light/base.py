"""The light contract.

A light is one file with a `Light` subclass, its description in JSON, and three Numba kernels:

    illuminate(p, x, u1, u2) -> (wx, wy, wz, distance, r, g, b)
        One sample of the light as seen from world position x: unit direction towards it, distance
        to it (1e30 for a light at infinity), and the incident radiance divided by the density of
        the sample over solid angle. So `rgb · f · cos θ` is an unbiased estimate of the reflected
        radiance. Lights without extent ignore u1, u2 and return intensity / distance².
    pdf(p, x, w) -> float
        Density over solid angle with which `illuminate` takes direction w from x; 0 for lights
        without extent, which no ray can hit.
    emitted(p, o, d) -> (distance, r, g, b)
        What a ray from o along unit d sees of the light itself; distance < 0 where it misses.

`p` is a row of ROW float32 numbers made by the description's `row()`. No kernel returns NaN, even
for x on the light. Shadows are the caller's business.
"""

from __future__ import annotations

import math
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from engine.numerics.description import Description, Radiance
from engine.numerics.vec import Vec

ROW = 24
POSITION, DIRECTION, INTENSITY, EXTRA = 0, 3, 6, 9


class Light(Description):
    """What every light has, whatever its type."""

    id: str = Field(min_length=1, max_length=64, description="unique name within the scene")
    intensity: Radiance = Field(
        (1.0, 1.0, 1.0), description="linear RGB; its unit is the light's own, see there"
    )
    enabled: bool = True

    has_extent: ClassVar[bool] = False

    def row(self) -> NDArray[np.float32]:
        """(ROW,) float32 parameters for the kernels; every kind has its own."""
        raise NotImplementedError


def unit(v: Vec, problem: str = "a direction is zero") -> Vec:
    """v at unit length; ValueError, saying `problem`, where it has none."""
    length = math.hypot(*v)
    if length < 1e-9:
        raise ValueError(problem)
    return (v[0] / length, v[1] / length, v[2] / length)


def towards(position: Vec, target: Vec) -> Vec:
    """Unit direction from position to target; ValueError where they are the same."""
    x, y, z = (b - a for a, b in zip(position, target, strict=True))
    return unit((x, y, z), "position and target are the same point")
