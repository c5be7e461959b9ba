"""Ward: a Gaussian of the facets' slopes, wider along or across the grain, over a diffuse base.

Ward 1992, *Measuring and Modeling Anisotropic Reflection*, eq. 5a, with δ and φ the polar angles of
the half vector h and x, y the axes of the grain, see `base.GRAIN`:

    f = ρ_d / π + ρ_s exp(-tan² δ (cos² φ / α_x² + sin² φ / α_y²)) / (4π α_x α_y √(cos θ_i cos θ_o))

The exponent is ((h·x / α_x)² + (h·y / α_y)²) / (h·n)², which needs no angles (Walter 2005, *Notes
on the Ward BRDF*). α_x and α_y, the root mean square slopes, are at least MIN_ALPHA. Reciprocal.

The formula is the original one. A sharp lobe reflects ρ_s cos θ_o, a wide one less from above: 0.90
ρ_s at α = 0.2, 0.59 at 0.5, 0.26 at 1. Towards grazing angles the root makes it grow without bound,
as 0.098 ρ_s / √cos θ_o for the worst widths, 1 and MIN_ALPHA: no lobe reflects more than ρ_s up to
89.4 degrees from the normal, but at 89.9 degrees this one reflects 2.35 ρ_s, a round one of 0.3
still 1.05.
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
from engine.numerics.description import Reflectance, Unit
from engine.numerics.dispatch import formula
from engine.numerics.sampling import cosine_hemisphere
from engine.numerics.vec import add, normalize, reflect, scale

MIN_ALPHA = 0.02  # a highlight about a degree wide
STEEPEST = 100.0  # minus the exponent from where the lobe, e⁻¹⁰⁰ of its peak, counts as nothing


class Ward(Material):
    """Brushed metal, lacquer, enamel: the model of many measured materials.

    The grain runs along the first texture coordinate of the surface. A texture of `roughness`
    multiplies both widths.
    """

    gloss_is_linear = True
    type: Literal["ward"] = "ward"
    diffuse: Annotated[Reflectance, Field(description="ρ_d, reflectance of the base")] = (
        0.5,
        0.5,
        0.5,
    )
    specular: Annotated[
        Reflectance, Field(description="ρ_s, reflectance of a narrow lobe at normal incidence")
    ] = (0.2, 0.2, 0.2)
    roughness: Annotated[
        Unit, Field(description="α_x, root mean square slope of the facets along the grain")
    ] = 0.2
    roughness_v: Annotated[
        Unit, Field(description="α_y, root mean square slope of the facets across the grain")
    ] = 0.1

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`; α_y stands as a multiple of α_x."""
        row = self._fill(self.diffuse, self.specular, self.roughness)
        row[EXTRA] = max(MIN_ALPHA, self.roughness_v) / max(MIN_ALPHA, self.roughness)
        row[GRAIN] = 1.0
        return row


@formula
def _alphas(p):
    """(α_x, α_y)."""
    along = max(MIN_ALPHA, float(p[ROUGHNESS]))
    return along, max(MIN_ALPHA, along * float(p[EXTRA]))


@formula
def _lobe(p, h):
    """exp(..) / (π α_x α_y): the density of the facets' slopes."""
    ax, ay = _alphas(p)
    g = to_grain(p, h)
    x, y, z2 = g[0] / ax, g[1] / ay, g[2] * g[2]
    r2 = x * x + y * y
    if r2 >= STEEPEST * z2:
        return 0.0
    return math.exp(-r2 / z2) / (math.pi * ax * ay)


@formula
def evaluate(p, wi, wo):
    """Eq. 5a."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    gloss = 0.25 * _lobe(p, half(wi, wo)[0]) / max(1e-30, math.sqrt(wi[2] * wo[2]))
    return add(
        scale(diffuse_colour(p), 1.0 / math.pi),
        scale(specular_colour(p), gloss),
    )


@njit
def sample(p, wo, u):
    """The base with its share of the reflectance, else a facet that mirrors wo, as Walter 2005.

    Of slopes stretched by 1 / α_x and 1 / α_y, the share of those longer than r is exp(-r²).
    """
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    if u[2] < share(diffuse_colour(p), specular_colour(p)):
        return cosine_hemisphere(u[0], u[1])
    ax, ay = _alphas(p)
    r, phi = math.sqrt(-math.log1p(-u[0])), 2.0 * math.pi * u[1]
    h = normalize((ax * r * math.cos(phi), ay * r * math.sin(phi), 1.0))
    return reflect(wo, from_grain(p, h))


@njit
def pdf(p, wi, wo):
    """Base: cos θ_i / π. Lobe: that of the slopes / (cos³ δ · 4 wo·h)."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    base = share(diffuse_colour(p), specular_colour(p))
    h, cos_d = half(wi, wo)
    lobe = _lobe(p, h) / max(1e-30, 4.0 * cos_d * h[2] * h[2] * h[2])
    return base * wi[2] / math.pi + (1.0 - base) * lobe
