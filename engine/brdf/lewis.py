"""Lewis's plausible Phong: the formula of `phong`, published a year before.

Lewis 1993, *Making Shaders More Physically Plausible*: Phong's shader, read as a BRDF, divides by
cos θ_i and so is not reciprocal. Without that, and with a factor that lets the lobe reflect ρ_s at
normal incidence,

    f = ρ_d / π + ρ_s (n + 2) / 2π · cosⁿ α

is plausible where ρ_d + ρ_s is at most 1. This is what Lafortune and Willems 1994 sample, so the
description fills the row of `Phong`, whose kernels and shader compute it.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from engine.brdf.base import Material
from engine.numerics.description import Reflectance


class Lewis(Material):
    """A matt or glossy plastic, as published in 1993."""

    gloss_is_linear = True
    type: Literal["lewis"] = "lewis"
    diffuse: Annotated[Reflectance, Field(description="ρ_d, reflectance of the base")] = (
        0.5,
        0.5,
        0.5,
    )
    specular: Annotated[
        Reflectance, Field(description="ρ_s, reflectance of the lobe at normal incidence")
    ] = (0.2, 0.2, 0.2)
    exponent: Annotated[
        float, Field(ge=0, le=1e5, description="n, sharpness of the lobe; 0 is widest")
    ] = 50.0

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`."""
        return self._fill(self.diffuse, self.specular, self.exponent)
