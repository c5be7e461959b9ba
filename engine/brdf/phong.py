"""Modified Phong: a cosine lobe about the mirror direction, over a diffuse base.

Lafortune and Willems 1994, *Using the Modified Phong Reflectance Model for Physically Based
Rendering*, eq. 3: f = k_d / π + k_s (n + 2) / 2π · cosⁿ α, with α the angle between wi and the
mirror image of wo. Reciprocal; no more than k_d + k_s is reflected, so energy is conserved where
their sum is at most 1. The lobe falls off as cos θ towards grazing angles.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from engine.brdf.base import ROUGHNESS, Material, diffuse_colour, share, specular_colour
from engine.numerics.description import Reflectance
from engine.numerics.dispatch import formula
from engine.numerics.frames import tangents, to_world
from engine.numerics.sampling import cosine_hemisphere, cosine_power_hemisphere
from engine.numerics.vec import add, dot, scale


class Phong(Material):
    """A matt or glossy plastic."""

    gloss_is_linear = True
    type: Literal["phong"] = "phong"
    diffuse: Annotated[Reflectance, Field(description="k_d, reflectance of the base")] = (
        0.5,
        0.5,
        0.5,
    )
    specular: Annotated[
        Reflectance, Field(description="k_s, reflectance of the lobe at normal incidence")
    ] = (0.2, 0.2, 0.2)
    exponent: Annotated[
        float, Field(ge=0, le=1e5, description="n, sharpness of the lobe; 0 is widest")
    ] = 50.0

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`."""
        return self._fill(self.diffuse, self.specular, self.exponent)


@formula
def _mirror(wo):
    return (-wo[0], -wo[1], wo[2])


@formula
def evaluate(p, wi, wo):
    """Eq. 3."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    value = scale(diffuse_colour(p), 1.0 / math.pi)
    cos_alpha = min(1.0, dot(_mirror(wo), wi))
    if cos_alpha > 0.0:
        n = float(p[ROUGHNESS])
        lobe = (n + 2.0) / (2.0 * math.pi) * cos_alpha**n
        value = add(value, scale(specular_colour(p), lobe))
    return value


@njit
def sample(p, wo, u):
    """The base with its share of the reflectance, else the lobe."""
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    if u[2] < share(diffuse_colour(p), specular_colour(p)):
        return cosine_hemisphere(u[0], u[1])
    r = _mirror(wo)
    s, t = tangents(r)
    return to_world(cosine_power_hemisphere(u[0], u[1], float(p[ROUGHNESS])), s, t, r)


@njit
def pdf(p, wi, wo):
    """Base: cos θ_i / π. Lobe: (n + 1) / 2π · cosⁿ α."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    base = share(diffuse_colour(p), specular_colour(p))
    density = base * wi[2] / math.pi
    cos_alpha = min(1.0, dot(_mirror(wo), wi))
    if cos_alpha > 0.0:
        n = float(p[ROUGHNESS])
        density += (1.0 - base) * (n + 1.0) / (2.0 * math.pi) * cos_alpha**n
    return density
