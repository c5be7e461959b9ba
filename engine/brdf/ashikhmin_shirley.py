"""Ashikhmin-Shirley: an anisotropic Phong lobe of the half vector over a coupled diffuse base.

Ashikhmin and Shirley 2000, *An Anisotropic Phong BRDF Model*, with h the half vector:

    ρ_s = √((n_u + 1)(n_v + 1)) / 8π · (n·h)^e / ((h·k) max(n·wi, n·wo)) · F(k·h)          eq. 4
      e = (n_u (h·u)² + n_v (h·v)²) / (1 - (h·n)²)
    ρ_d = 28 R_d / 23π · (1 - R_s) (1 - (1 - n·wi / 2)⁵) (1 - (1 - n·wo / 2)⁵)              eq. 5

k is wi or wo, which have the same angle to h. u, v are the axes of the grain, see `base.GRAIN`: a
large n_v makes the highlight narrow across the grain's v axis. Reciprocal. It reflects no more
than it receives; the base reflects R_d (1 - R_s) (1 - (1 - cos θ_o / 2)⁵). F is that of `fresnel`.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from engine.brdf.base import (
    EXTRA,
    GRAIN,
    ROUGHNESS,
    Material,
    diffuse_colour,
    from_grain,
    half,
    share,
    specular_colour,
    to_grain,
)
from engine.brdf.fresnel import fresnel
from engine.numerics.description import Reflectance
from engine.numerics.dispatch import formula
from engine.numerics.sampling import cosine_hemisphere
from engine.numerics.vec import add, dot, mul, reflect, scale

GRAZING = 1e-12  # a half vector this close to perpendicular to wo mirrors nothing

# Near grazing angles the value of a sharper lobe would have no digits left in a shader's float32.
Exponent = Annotated[float, Field(ge=0, le=500)]


class AshikhminShirley(Material):
    """Brushed metal, varnished wood, satin: highlights stretched across the grain.

    The grain, u, runs along the first texture coordinate of the surface.
    """

    type: Literal["ashikhmin_shirley"] = "ashikhmin_shirley"
    diffuse: Annotated[Reflectance, Field(description="R_d, reflectance of the base")] = (
        0.5,
        0.5,
        0.5,
    )
    specular: Annotated[
        Reflectance, Field(description="R_s, reflectance of the lobe at normal incidence")
    ] = (0.2, 0.2, 0.2)
    exponent_u: Annotated[
        Exponent, Field(description="n_u, sharpness of the lobe along the grain")
    ] = 10.0
    exponent_v: Annotated[
        Exponent, Field(description="n_v, sharpness of the lobe across the grain")
    ] = 100.0

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`."""
        row = self._fill(self.diffuse, self.specular, self.exponent_u)
        row[EXTRA] = self.exponent_v
        row[GRAIN] = 1.0
        return row


@formula
def matt(wi, wo):
    """ρ_d over its colour."""
    return 28.0 / (23.0 * math.pi) * _base(wi[2]) * _base(wo[2])


@formula
def _base(c):
    """What either direction, at the cosine c, contributes to ρ_d."""
    return 1.0 - (1.0 - 0.5 * c) ** 5


@formula
def _base_colour(p):
    """R_d (1 - R_s)."""
    f0 = specular_colour(p)
    return mul(diffuse_colour(p), (1.0 - f0[0], 1.0 - f0[1], 1.0 - f0[2]))


@formula
def _lobe(p, h):
    """√((n_u + 1)(n_v + 1)) / 2π · (n·h)^e, which is the density of the half vectors' sampler."""
    nu, nv = float(p[ROUGHNESS]), float(p[EXTRA])
    g = to_grain(p, h)
    x, y = g[0] * g[0], g[1] * g[1]
    power = min(1.0, h[2]) ** ((nu * x + nv * y) / (x + y)) if x + y > 0.0 else 1.0
    return math.sqrt((nu + 1.0) * (nv + 1.0)) / (2.0 * math.pi) * power


@formula
def evaluate(p, wi, wo):
    """ρ_d + ρ_s."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    value = scale(_base_colour(p), matt(wi, wo))
    h, cos_d = half(wi, wo)
    if cos_d <= GRAZING:
        return value
    gloss = _lobe(p, h) / (4.0 * max(1e-30, cos_d * max(wi[2], wo[2])))
    return add(value, scale(fresnel(specular_colour(p), cos_d), gloss))


@njit
def _base_share(p, wo):
    """Probability of sampling the base: its part of the light reflected towards wo, roughly."""
    base = scale(_base_colour(p), _base(wo[2]))
    return share(base, fresnel(specular_colour(p), wo[2]))


@njit
def sample(p, wo, u):
    """The base with its share of the reflectance, else a half vector that mirrors wo (eq. 9, 10).

    The paper's azimuth of one quadrant, φ = atan(√((n_u + 1) / (n_v + 1)) tan(π u / 2)), goes on
    round the circle here, so that neighbouring numbers give neighbouring directions.
    """
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    if u[2] < _base_share(p, wo):
        return cosine_hemisphere(u[0], u[1])
    nu, nv = float(p[ROUGHNESS]), float(p[EXTRA])
    phi = math.atan2(
        math.sqrt(nu + 1.0) * math.sin(2.0 * math.pi * u[1]),
        math.sqrt(nv + 1.0) * math.cos(2.0 * math.pi * u[1]),
    )
    c, s = math.cos(phi), math.sin(phi)
    z = (1.0 - u[0]) ** (1.0 / (nu * c * c + nv * s * s + 1.0))
    r = math.sqrt(max(0.0, 1.0 - z * z))
    h = from_grain(p, (r * c, r * s, z))
    if dot(wo, h) <= GRAZING:
        return (0.0, 0.0, 0.0)
    return reflect(wo, h)


@njit
def pdf(p, wi, wo):
    """Base: cos θ_i / π. Lobe: that of the half vectors / (4 wo·h), eq. 8."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    base = _base_share(p, wo)
    density = base * wi[2] / math.pi
    h, cos_d = half(wi, wo)
    if cos_d > GRAZING:
        density += (1.0 - base) * _lobe(p, h) / (4.0 * cos_d)
    return density
