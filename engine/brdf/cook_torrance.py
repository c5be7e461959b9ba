"""Cook-Torrance: V-shaped grooves of mirrors, over a diffuse base that gets what they let through.

Cook and Torrance 1982, *A Reflectance Model for Computer Graphics*, with h the half vector:

    f_s = F D G / (4 cos θ_i cos θ_o)
    D = exp(-tan² θ_h / m²) / (π m² cos⁴ θ_h)                   Beckmann's distribution of slopes
    G = min(1, 2 (n·h)(n·wo) / (wo·h), 2 (n·h)(n·wi) / (wo·h))  light blocked within one groove
    F = F0 + (F90 - F0)(1 - wo·h)⁵                              see `fresnel`

As printed R_s has a π in place of the 4, and D has none: four times as much. Facets reflect what
meets them with ∫ D cos θ_h dh = 1 and the 4, which is from the Jacobian of the half vector (Walter,
Marschner, Li, Torrance 2007, eq. 20, 25). m, the root mean square slope of the facets, is
`roughness` but at least MIN_SLOPE. F0 is `specular`, and F Schlick's where the paper has Fresnel's.

The paper's sum is s R_s + d R_d with s + d = 1. Here the base is that of `ggx`, see `coupled`, so
that the same reflectances make the same kind of material in both models. With `specular` 0 it is
exactly Lambert's.

Both parts are reciprocal. Facets alone never reflect more than they receive, as G is no more than
what either direction sees of them. Light that bounces between them is lost: at `roughness` 1 white
ones seen from above keep 45 % of it, at 0.5 still 89 %. Over a white base they reflect 0.4 % too
much at worst, at `roughness` 0.13, since what the base gets is reckoned for a level interface.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from engine.brdf.base import ROUGHNESS, Material, half, specular_colour
from engine.brdf.coupled import base_share, coupled_base
from engine.brdf.fresnel import fresnel
from engine.numerics.description import Reflectance, Unit
from engine.numerics.dispatch import formula
from engine.numerics.sampling import cosine_hemisphere
from engine.numerics.vec import add, reflect, scale

MIN_SLOPE = 0.002  # a highlight about a tenth of a degree wide
STEEPEST = 100.0  # (tan θ_h / m)² from where D, e⁻¹⁰⁰ of its peak, counts as nothing


class CookTorrance(Material):
    """Metals (`diffuse` 0) and plastics whose highlights end more sharply than GGX's."""

    type: Literal["cook_torrance"] = "cook_torrance"
    diffuse: Annotated[Reflectance, Field(description="reflectance of the base")] = (0.5, 0.5, 0.5)
    specular: Annotated[Reflectance, Field(description="F0, reflectance at normal incidence")] = (
        0.04,
        0.04,
        0.04,
    )
    roughness: Annotated[Unit, Field(description="m, root mean square slope of the facets")] = 0.3

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`."""
        return self._fill(self.diffuse, self.specular, self.roughness)


@formula
def _slope(p):
    return max(MIN_SLOPE, float(p[ROUGHNESS]))


@formula
def _beckmann(m, h):
    """D, with sin² written as x² + y² so that sharp lobes keep their digits."""
    m2, z2 = m * m, h[2] * h[2]
    r2 = h[0] * h[0] + h[1] * h[1]
    if r2 >= STEEPEST * m2 * z2:
        return 0.0
    return math.exp(-r2 / (m2 * z2)) / (math.pi * m2 * z2 * z2)


@formula
def visible(h, cos_d, wi, wo):
    """G / (4 cos θ_i cos θ_o): of the two that block, the lower direction does, and cancels."""
    return min(
        1.0 / max(1e-30, 4.0 * wi[2] * wo[2]),
        h[2] / max(1e-30, 2.0 * cos_d * max(wi[2], wo[2])),
    )


@formula
def evaluate(p, wi, wo):
    """f_d + f_s."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    h, cos_d = half(wi, wo)
    gloss = visible(h, cos_d, wi, wo) * _beckmann(_slope(p), h)
    return add(coupled_base(p, wi, wo), scale(fresnel(specular_colour(p), cos_d), gloss))


@njit
def sample(p, wo, u):
    """The base with its share of the reflectance, else a facet that mirrors wo.

    The share of facets steeper than θ is exp(-tan² θ / m²).
    """
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    if u[2] < base_share(p, wo):
        return cosine_hemisphere(u[0], u[1])
    tangent = _slope(p) * math.sqrt(-math.log1p(-u[0]))
    z = 1.0 / math.sqrt(1.0 + tangent * tangent)
    r, phi = tangent * z, 2.0 * math.pi * u[1]
    return reflect(wo, (r * math.cos(phi), r * math.sin(phi), z))


@njit
def pdf(p, wi, wo):
    """Base: cos θ_i / π. Facets: D cos θ_h / (4 wo·h)."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    base = base_share(p, wo)
    h, cos_d = half(wi, wo)
    facets = _beckmann(_slope(p), h) * h[2] / max(1e-30, 4.0 * cos_d)
    return base * wi[2] / math.pi + (1.0 - base) * facets
