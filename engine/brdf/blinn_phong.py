"""Blinn-Phong: a cosine lobe of the half vector about the normal, over a diffuse base.

Blinn 1977, *Models of Light Reflection for Computer Synthesized Pictures*, without its Fresnel and
masking terms: f = k_d / π + k_s N(n) cosⁿ θ_h. The factor

    N(n) = (n + 2)(n + 4) / (8π (2^(-n/2) + n))

makes the lobe reflect exactly k_s at normal incidence (Giesen 2009, *Phong and Blinn-Phong
normalization factors*); it reflects less at every other angle. Reciprocal, since the half vector
does not tell wi from wo.
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
from engine.numerics.sampling import cosine_hemisphere, cosine_power_hemisphere
from engine.numerics.vec import add, dot, normalize, reflect, scale

GRAZING = 1e-12  # a half vector this close to perpendicular to wo mirrors nothing


class BlinnPhong(Material):
    """A matt or glossy plastic whose highlights lengthen towards grazing angles."""

    gloss_is_linear = True
    type: Literal["blinn_phong"] = "blinn_phong"
    diffuse: Annotated[Reflectance, Field(description="k_d, reflectance of the base")] = (
        0.5,
        0.5,
        0.5,
    )
    specular: Annotated[
        Reflectance, Field(description="k_s, reflectance of the lobe at normal incidence")
    ] = (0.2, 0.2, 0.2)
    exponent: Annotated[
        float, Field(ge=0, le=1e5, description="n, sharpness of the lobe; 0 is Lambert's")
    ] = 100.0

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`."""
        return self._fill(self.diffuse, self.specular, self.exponent)


@formula
def normalisation(n):
    """N(n)."""
    return (n + 2.0) * (n + 4.0) / (8.0 * math.pi * (2.0 ** (-0.5 * n) + n))


@formula
def evaluate(p, wi, wo):
    """k_d / π + k_s N(n) cosⁿ θ_h."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    n = float(p[ROUGHNESS])
    h = normalize(add(wi, wo))
    return add(
        scale(diffuse_colour(p), 1.0 / math.pi),
        scale(specular_colour(p), normalisation(n) * min(1.0, h[2]) ** n),
    )


@njit
def sample(p, wo, u):
    """The base with its share of the reflectance, else a half vector that mirrors wo."""
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    if u[2] < share(diffuse_colour(p), specular_colour(p)):
        return cosine_hemisphere(u[0], u[1])
    h = cosine_power_hemisphere(u[0], u[1], float(p[ROUGHNESS]))
    if dot(wo, h) <= GRAZING:
        return (0.0, 0.0, 0.0)
    return reflect(wo, h)


@njit
def pdf(p, wi, wo):
    """Base: cos θ_i / π. Lobe: (n + 1) / 2π · cosⁿ θ_h / (4 wo·h)."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    base = share(diffuse_colour(p), specular_colour(p))
    density = base * wi[2] / math.pi
    h = normalize(add(wi, wo))
    cos_d = dot(wo, h)
    if cos_d > GRAZING:
        n = float(p[ROUGHNESS])
        lobe = (n + 1.0) / (2.0 * math.pi) * min(1.0, h[2]) ** n
        density += (1.0 - base) * lobe / (4.0 * cos_d)
    return density
