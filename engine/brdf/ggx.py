"""GGX (Trowbridge-Reitz) microfacets over a diffuse base that gets what the facets let through.

Facets (Walter, Marschner, Li, Torrance 2007, *Microfacet Models for Refraction through Rough
Surfaces*): f_s = F D G / (4 cos θ_i cos θ_o) with
    D = α² / (π (cos² θ_h (α² - 1) + 1)²)                                   (eq. 33)
    G = 1 / (1 + Λ(wi) + Λ(wo)), Λ = (√(1 + α² tan² θ) - 1) / 2             height-correlated Smith,
        Heitz 2014, *Understanding the Masking-Shadowing Function*, eq. 99
    F = F0 + (F90 - F0)(1 - wo·h)⁵                                          see `fresnel`
F0 is `specular`, α the square of `roughness` (Burley 2012, §5.4) but at least MIN_ALPHA. With
`specular` 0 it is exactly Lambert's model.

Base (Shirley, Smits, Hu, Lafortune 1997): see `coupled`.

Both parts are reciprocal. Light that bounces between facets is lost: at `roughness` 1 white facets
seen from above keep 31 % of it, at 0.5 still 92 %.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from engine.brdf.base import ROUGHNESS, Material, specular_colour
from engine.brdf.coupled import base_share, coupled_base
from engine.brdf.fresnel import fresnel
from engine.numerics.description import Reflectance, Unit
from engine.numerics.dispatch import formula
from engine.numerics.sampling import cosine_hemisphere
from engine.numerics.vec import add, cross, dot, normalize, reflect, scale

MIN_ALPHA = 0.002  # a highlight about a tenth of a degree wide


class Ggx(Material):
    """Metals (`diffuse` 0, `specular` the metal's colour) and plastics (`specular` about 0.04)."""

    type: Literal["ggx"] = "ggx"
    diffuse: Annotated[Reflectance, Field(description="reflectance of the base")] = (0.5, 0.5, 0.5)
    specular: Annotated[Reflectance, Field(description="F0, reflectance at normal incidence")] = (
        0.04,
        0.04,
        0.04,
    )
    roughness: Annotated[Unit, Field(description="perceptual; α is its square")] = 0.5

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`."""
        return self._fill(self.diffuse, self.specular, self.roughness)


@formula
def _alpha(p):
    roughness = float(p[ROUGHNESS])
    return max(MIN_ALPHA, roughness * roughness)


@formula
def _distribution(alpha, h):
    """D, with 1 - cos² written as x² + y² so that sharp lobes keep their digits."""
    a2 = alpha * alpha
    t = a2 * h[2] * h[2] + h[0] * h[0] + h[1] * h[1]
    return a2 / (math.pi * t * t)


@formula
def _stretched(alpha, c):
    """cos θ √(1 + α² tan² θ)."""
    a2 = alpha * alpha
    return math.sqrt(a2 + (1.0 - a2) * c * c)


@formula
def visible(p, wi, wo):
    """G / (4 cos θ_i cos θ_o), simplified so that nothing vanishes at grazing angles."""
    alpha = _alpha(p)
    return 0.5 / max(1e-30, wo[2] * _stretched(alpha, wi[2]) + wi[2] * _stretched(alpha, wo[2]))


@formula
def evaluate(p, wi, wo):
    """f_d + f_s."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    h = normalize(add(wi, wo))
    gloss = visible(p, wi, wo) * _distribution(_alpha(p), h)
    return add(coupled_base(p, wi, wo), scale(fresnel(specular_colour(p), dot(wo, h)), gloss))


@njit
def _visible_normal(alpha, wo, u1, u2):
    """A facet normal with density D · G1(wo) · (wo·h) / cos θ_o.

    Heitz 2018, *Sampling the GGX Distribution of Visible Normals*: stretch the surface so that the
    facets become a hemisphere, pick a point of its projection along the view, stretch back.
    """
    v = normalize((alpha * wo[0], alpha * wo[1], wo[2]))
    t1 = (1.0, 0.0, 0.0)
    if v[0] * v[0] + v[1] * v[1] > 0.0:
        t1 = normalize((-v[1], v[0], 0.0))
    t2 = cross(v, t1)
    # A point of the unit disk, squeezed into the half disk plus half ellipse that the view sees.
    r, phi = math.sqrt(u1), 2.0 * math.pi * u2
    a, b = r * math.cos(phi), r * math.sin(phi)
    s = 0.5 * (1.0 + v[2])
    b = (1.0 - s) * math.sqrt(max(0.0, 1.0 - a * a)) + s * b
    n = add(add(scale(t1, a), scale(t2, b)), scale(v, math.sqrt(max(0.0, 1.0 - a * a - b * b))))
    return normalize((alpha * n[0], alpha * n[1], max(0.0, n[2])))


@njit
def sample(p, wo, u):
    """The base with its share of the reflectance, else a visible facet that mirrors wo."""
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    if u[2] < base_share(p, wo):
        return cosine_hemisphere(u[0], u[1])
    return reflect(wo, _visible_normal(_alpha(p), wo, u[0], u[1]))


@njit
def pdf(p, wi, wo):
    """Base: cos θ_i / π. Facets: D · G1(wo) / (4 cos θ_o), the Jacobian 1 / (4 wo·h) included."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    base = base_share(p, wo)
    alpha = _alpha(p)
    h = normalize(add(wi, wo))
    facets = 0.5 * _distribution(alpha, h) / (wo[2] + _stretched(alpha, wo[2]))
    return base * wi[2] / math.pi + (1.0 - base) * facets
