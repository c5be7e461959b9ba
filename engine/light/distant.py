"""Parallel light from infinity, such as the sun; `intensity` is irradiance, W·m⁻².

It is the irradiance of a surface that faces the light; one that is turned away by θ gets cos θ of
it. The sun's disk has no extent here.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.light.base import Light, no_formula, no_pdf, nothing_emitted, unit
from engine.numerics.description import Point


class DistantLight(Light):
    """Parallel light; intensity is the irradiance of a surface that faces it, in W·m⁻²."""

    type: Literal["distant"] = "distant"
    direction: Annotated[Point, Field(description="where the light travels, of any length")]

    @model_validator(mode="after")
    def _has_direction(self) -> DistantLight:
        unit(self.direction, "direction is zero")
        return self

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`."""
        return self.start(direction=unit(self.direction))


@njit
def illuminate(p, texels, x, size, u1, u2):
    """The irradiance, from everywhere the same."""
    return (
        -float(p[3]),
        -float(p[4]),
        -float(p[5]),
        1e30,
        float(p[6]),
        float(p[7]),
        float(p[8]),
    )


pdf, emitted = no_pdf, nothing_emitted
irradiance, glance = no_formula, illuminate
