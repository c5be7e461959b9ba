"""Lambert's model: radiance does not depend on direction (Lambert 1760, *Photometria*).

f = ρ / π; reciprocal; its albedo is ρ.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from engine.brdf.base import Material, diffuse_colour
from engine.numerics.description import Reflectance
from engine.numerics.dispatch import formula
from engine.numerics.sampling import cosine_hemisphere
from engine.numerics.vec import scale


class Diffuse(Material):
    """A matt surface."""

    type: Literal["diffuse"] = "diffuse"
    diffuse: Annotated[Reflectance, Field(description="ρ, the albedo")] = (0.5, 0.5, 0.5)

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`."""
        return self._fill(self.diffuse)


@formula
def evaluate(p, wi, wo):
    """ρ / π above the surface."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    return scale(diffuse_colour(p), 1.0 / math.pi)


@njit
def sample(p, wo, u):
    """Cosine-distributed."""
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    return cosine_hemisphere(u[0], u[1])


@njit
def pdf(p, wi, wo):
    """cos θ_i / π."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    return wi[2] / math.pi
