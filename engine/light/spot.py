"""A point that shines into a cone; `intensity` is radiant intensity on the axis, W·sr⁻¹.

The intensity is constant in the inner cone and falls to 0 at the rim of the outer one. With
c = cos θ the falloff is the smoothstep 3s² - 2s³ of s = (c - c_outer) / (c_inner - c_outer), whose
mean is one half, so the lamp emits 2π I (1 - (c_inner + c_outer) / 2) watts.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.light.base import EXTRA, Light, no_formula, no_pdf, nothing_emitted, towards
from engine.numerics.description import Point


class SpotLight(Light):
    """A point that shines into a cone; intensity on its axis, in W·sr⁻¹."""

    type: Literal["spot"] = "spot"
    position: Point
    target: Annotated[Point, Field(description="where the axis of the cone points")]
    cone_degrees: Annotated[
        float, Field(ge=0.1, le=90, description="from the axis to the rim of the outer cone")
    ] = 30.0
    penumbra_degrees: Annotated[
        float,
        Field(
            ge=0,
            le=90,
            description="from the rim inwards, where the light falls off; to the axis at most",
        ),
    ] = 10.0

    @model_validator(mode="after")
    def _has_an_axis(self) -> SpotLight:
        towards(self.position, self.target)
        return self

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`; then 1 - cos of the outer and of the inner cone."""
        outer = math.radians(self.cone_degrees)
        inner = max(0.0, outer - math.radians(self.penumbra_degrees))
        row = self.start(self.position, towards(self.position, self.target))
        # 1 - cos keeps its digits where the cone is narrow.
        row[EXTRA : EXTRA + 2] = 2 * math.sin(outer / 2) ** 2, 2 * math.sin(inner / 2) ** 2
        return row


@njit
def illuminate(p, texels, x, size, u1, u2):
    """I · falloff / r²."""
    dx, dy, dz = p[0] - x[0], p[1] - x[1], p[2] - x[2]
    r2 = dx * dx + dy * dy + dz * dz
    if r2 < 1e-20:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    r = math.sqrt(r2)
    wx, wy, wz = dx / r, dy / r, dz / r
    # 1 - cos of the angle to the axis is half the squared distance between the unit vectors.
    ax, ay, az = p[3] + wx, p[4] + wy, p[5] + wz
    versine = 0.5 * (ax * ax + ay * ay + az * az)
    outer, inner = float(p[9]), float(p[10])
    falloff = 0.0
    if versine <= inner:
        falloff = 1.0
    elif versine < outer:
        s = (outer - versine) / (outer - inner)
        falloff = s * s * (3.0 - 2.0 * s)
    k = falloff / r2
    return (wx, wy, wz, r, p[6] * k, p[7] * k, p[8] * k)


pdf, emitted = no_pdf, nothing_emitted
irradiance, glance = no_formula, illuminate
