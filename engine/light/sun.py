"""The sun: parallel light with the soft shadows of a disk; `intensity` is irradiance, W·m⁻².

It is the irradiance E of a surface that faces it, whatever the angle that it fills. Its radiance
is the same all over, E / (π sin²(diameter / 2)). With a clear sky around it (`engine.light.sky`) an
intensity of 80 to 100 is that of a high sun.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.light.base import EXTRA, Light, unit
from engine.light.cap import cap_irradiance
from engine.numerics.description import Point
from engine.numerics.frames import tangents, to_world
from engine.numerics.sampling import uniform_cone

INFINITE = 1e30


class SunLight(Light):
    """A distant disk; intensity is the irradiance of a surface that faces it, in W·m⁻²."""

    type: Literal["sun"] = "sun"
    direction: Annotated[Point, Field(description="where the light travels, of any length")]
    diameter_degrees: Annotated[
        float, Field(ge=0.01, le=90, description="that its disk fills; the sun's is 0.53")
    ] = 0.53

    has_extent: ClassVar[bool] = True

    @model_validator(mode="after")
    def _has_direction(self) -> SunLight:
        unit(self.direction, "direction is zero")
        return self

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`, radiance in place of intensity; then 1 - cos of half the diameter."""
        half = math.radians(self.diameter_degrees) / 2
        row = self.start(direction=unit(self.direction))
        row[6:9] /= math.pi * math.sin(half) ** 2
        row[EXTRA] = 2 * math.sin(half / 2) ** 2
        return row


@njit
def _sees(p, w):
    """Whether w lies in the disk: 1 - cos is half the squared distance of unit vectors."""
    ax, ay, az = p[3] + w[0], p[4] + w[1], p[5] + w[2]
    return 0.5 * (ax * ax + ay * ay + az * az) <= p[9]


@njit
def illuminate(p, texels, x, size, u1, u2):
    """Uniform over the solid angle, L · solid angle."""
    z = (-np.float64(p[3]), -np.float64(p[4]), -np.float64(p[5]))
    versine = np.float64(p[9])
    s, t = tangents(z)
    w = to_world(uniform_cone(u1, u2, versine), s, t, z)
    weight = 2.0 * math.pi * versine
    return (w[0], w[1], w[2], INFINITE, p[6] * weight, p[7] * weight, p[8] * weight)


@njit
def pdf(p, x, w):
    """1 / solid angle."""
    return 1.0 / (2.0 * math.pi * p[9]) if _sees(p, w) else 0.0


@njit
def emitted(p, o, d):
    """The radiance, at infinity."""
    if not _sees(p, d):
        return (-1.0, 0.0, 0.0, 0.0)
    return (INFINITE, float(p[6]), float(p[7]), float(p[8]))


@njit
def irradiance(p, x, n, g):
    """Of its cone."""
    versine = np.float64(p[9])
    axis = (-np.float64(p[3]), -np.float64(p[4]), -np.float64(p[5]))
    return cap_irradiance(p, axis, versine * (2.0 - versine), n, g)


glance = illuminate
