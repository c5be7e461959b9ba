"""A ball that shines outwards; `intensity` is its radiance, W·sr⁻¹·m⁻².

Every point emits the same radiance in every direction that leaves it. The lamp is no part of the
geometry: it casts no shadow and reflects nothing, and within it there is no light.

From x, at distance d from its centre, it fills a cone of half angle asin(R / d), over whose solid
angle 2π (1 - √(1 - R² / d²)) it is sampled evenly (Wang 1992, *Physically Correct Direct Lighting
for Distribution Ray Tracing*). A surface that faces it has an irradiance of π L R² / d².
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from engine.light.base import DARK, EXTRA, Light
from engine.light.cap import cap_irradiance
from engine.numerics.description import Point
from engine.numerics.frames import tangents
from engine.numerics.sampling import uniform_cone
from engine.numerics.vec import scale


class SphereLight(Light):
    """A round lamp; intensity is its radiance, in W·sr⁻¹·m⁻²."""

    type: Literal["sphere"] = "sphere"
    position: Annotated[Point, Field(description="its centre")]
    radius: Annotated[float, Field(ge=1e-4, le=1e6, description="metres")] = 0.1

    has_extent: ClassVar[bool] = True

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`; then the radius."""
        row = self.start(self.position)
        row[EXTRA] = self.radius
        return row


@njit
def _cone(p, x):
    """(to the centre, distance to it, 1 - cos of the cone); 1 - cos is 0 for x within."""
    c = (p[0] - x[0], p[1] - x[1], p[2] - x[2])
    d2 = c[0] * c[0] + c[1] * c[1] + c[2] * c[2]
    s2 = np.float64(p[9]) * p[9]
    if d2 <= s2:
        return c, 0.0, 0.0
    s2 /= d2
    return c, math.sqrt(d2), s2 / (1.0 + math.sqrt(1.0 - s2))


@njit
def _near(c, radius, w):
    """Distance along unit w to the front of a ball with its centre at c; -1 where it misses.

    The chord's middle is found first: the difference of squares would lose the digits.
    """
    t = c[0] * w[0] + c[1] * w[1] + c[2] * w[2]
    mx, my, mz = c[0] - t * w[0], c[1] - t * w[1], c[2] - t * w[2]
    h2 = radius * radius - (mx * mx + my * my + mz * mz)
    if t <= 0.0 or h2 < 0.0:
        return -1.0
    return max(0.0, t - math.sqrt(h2))


@njit
def illuminate(p, texels, x, size, u1, u2):
    """Uniform over the solid angle, L · solid angle."""
    c, d, versine = _cone(p, x)
    if versine <= 0.0:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    z = (c[0] / d, c[1] / d, c[2] / d)
    s, t = tangents(z)
    a, b, k = uniform_cone(u1, u2, versine)
    w = (
        a * s[0] + b * t[0] + k * z[0],
        a * s[1] + b * t[1] + k * z[1],
        a * s[2] + b * t[2] + k * z[2],
    )
    r = _near(c, np.float64(p[9]), w)
    if r < 0.0:  # just past the rim, by rounding
        r = math.sqrt(d * d - np.float64(p[9]) * p[9])
    weight = 2.0 * math.pi * versine
    return (w[0], w[1], w[2], r, p[6] * weight, p[7] * weight, p[8] * weight)


@njit
def pdf(p, x, w):
    """1 / solid angle."""
    c, _, versine = _cone(p, x)
    if versine <= 0.0 or _near(c, np.float64(p[9]), w) < 0.0:
        return 0.0
    return 1.0 / (2.0 * math.pi * versine)


@njit
def emitted(p, o, d):
    """The radiance, where a ray from without meets the ball."""
    c, _, versine = _cone(p, o)
    t = _near(c, np.float64(p[9]), d) if versine > 0.0 else -1.0
    if t < 0.0:
        return (-1.0, 0.0, 0.0, 0.0)
    return (t, float(p[6]), float(p[7]), float(p[8]))


@njit
def irradiance(p, x, n, g):
    """Of its cone."""
    c, d, versine = _cone(p, x)
    if versine <= 0.0:
        return DARK
    return cap_irradiance(p, scale(c, 1.0 / d), versine * (2.0 - versine), n, g)


glance = illuminate
