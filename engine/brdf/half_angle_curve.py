"""Facets whose distribution is a curve of points: measured materials, and what a hand draws.

Ashikhmin, Premože, Shirley 2000, *A Microfacet-Based BRDF Generator*, and Ngan, Durand, Matusik
2005, *Experimental Analysis of BRDF Models*, leave the distribution of half vectors free, and
Ben-Artzi, Egan, Ramamoorthi, Durand 2008 edit it (§3.1, appendix A). Here it stands in place of
Beckmann's in `cook_torrance`, with the F, G and base of that model:

    f_s = F D G / (4 cos θ_i cos θ_o),    D = c(θ_h) / π sr⁻¹

The curve c is a line from node to node over the place u of the half angle, see `half_angle`. Its 22
nodes lie at every third of 64 tents, so that the basis of `brdf_editing` holds every curve exactly.
1 is the distribution of facets that lie evenly; c of Blinn and Phong's exponent n is
(n/2 + 1) cosⁿ θ_h.

The mean of the curve, weighed by the cosine, is the part of the surface that facets cover:

    ∫ D cos θ_h dh = Σ_k w_k c_k

Grooves reflect no more than they receive as long as it is at most 1, whatever the curve: G is what
a groove of two facets shows of them. Over a white base it is 0.7 % too much at worst, of facets all
15 degrees steep, since what the base gets is reckoned for a level interface. A curve that covers
more is scaled down, or refused: `energy`. One that covers less loses light.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, ValidationInfo, field_validator

from engine.brdf.base import EXTRA, Material, half, specular_colour
from engine.brdf.cook_torrance import visible
from engine.brdf.coupled import base_share, coupled_base
from engine.brdf.fresnel import fresnel
from engine.brdf.half_angle import angle_of, place_of
from engine.numerics.description import Reflectance
from engine.numerics.dispatch import formula
from engine.numerics.sampling import cosine_hemisphere
from engine.numerics.vec import add, reflect, scale

NODES = 22
BANDS = NODES - 1
COVER = EXTRA + NODES  # place of the part of the surface that facets cover, behind the curve
ROUNDING = 1e-4  # of a cover that is meant to be 1, by nodes written with four places
HALVINGS = 40  # of a band, until a sampled place is as good as exact


@formula
def _even(u):
    """∫ cos θ_h / π dh up to a place u: the cover of the curve 1."""
    v = u**4
    return v * (2.0 - v)


@formula
def _rising(u):
    """The cover of the curve u."""
    return u**5 * (8.0 / 5.0 - 8.0 / 9.0 * u**4)


def _weights() -> NDArray[np.float64]:
    """(NODES,): w_k, the cover of a curve that is 1 at node k and 0 at all others."""
    place, k = np.linspace(0, 1, NODES), np.arange(BANDS)
    even, rising = np.diff(_even.py_func(place)), BANDS * np.diff(_rising.py_func(place))
    here, there = (k + 1) * even - rising, rising - k * even
    return np.append(here, 0.0) + np.append(0.0, there)


WEIGHTS = _weights()
ANGLES_DEGREES = np.degrees(angle_of(np.linspace(0, 1, NODES)))

Level = Annotated[float, Field(ge=0, le=1e6)]


def cover(curve: NDArray[np.float64] | tuple[float, ...]) -> float:
    """The part of the surface that facets of a curve cover."""
    return float(WEIGHTS @ np.asarray(curve, np.float64))


class HalfAngleCurve(Material):
    """Cloth, paint, metals: any distribution of facets, node by node."""

    type: Literal["half_angle_curve"] = "half_angle_curve"
    diffuse: Annotated[Reflectance, Field(description="reflectance of the base")] = (0.5, 0.5, 0.5)
    specular: Annotated[Reflectance, Field(description="F0, reflectance at normal incidence")] = (
        0.04,
        0.04,
        0.04,
    )
    energy: Annotated[
        Literal["scale", "refuse"],
        Field(description="what becomes of a curve that would reflect more than it receives"),
    ] = "scale"
    # By default Blinn and Phong's lobe of exponent 50.
    curve: Annotated[
        tuple[Level, ...],
        Field(
            min_length=NODES,
            max_length=NODES,
            description="c, density of facets over that of facets which lie evenly",
            json_schema_extra={
                "angles_degrees": ANGLES_DEGREES.round(4).tolist(),
                "weights": WEIGHTS.tolist(),
            },
        ),
    ] = (
        25.9939, 26.0003, 25.9211, 25.5231, 24.4365, 22.2497, 18.7104, 14.003, 8.9055, 4.5429,
        1.7275, 0.4445, 0.0676, 0.005, 0.0002, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0,
    )  # fmt: skip

    @field_validator("curve")
    @classmethod
    def _reflects_no_more_than_it_gets(
        cls, curve: tuple[float, ...], info: ValidationInfo
    ) -> tuple[float, ...]:
        covered = cover(curve)
        if info.data.get("energy") == "refuse" and covered > 1 + ROUNDING:
            raise ValueError(
                f"facets of this curve cover {covered:.3g} times the surface, and would reflect "
                "more than they receive: lower it, or have it scaled by 'energy': 'scale'"
            )
        return curve

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`; the curve as it is scaled."""
        row = self._fill(self.diffuse, self.specular)
        covered = cover(self.curve)
        row[EXTRA:COVER] = np.asarray(self.curve) / max(1.0, covered)
        row[COVER] = min(1.0, covered)
        return row

    @property
    def exponent(self) -> float:
        """Of Blinn and Phong's lobe whose facets have the same mean sin² θ_h, 1 / (n/2 + 2)."""
        place = np.linspace(0, 1, 64 * BANDS + 1)
        middle = 0.5 * (place[1:] + place[:-1])
        share = np.diff(_even.py_func(place)) * np.interp(middle, place[::64], self.curve)
        if not share.any():
            return 0.0
        return max(0.0, 2 * share.sum() / float(share @ _even.py_func(middle)) - 4)


@formula
def _distribution(p, h):
    """D."""
    x = BANDS * place_of(h[2])
    k = min(int(x), BANDS - 1)
    here, there = float(p[EXTRA + k]), float(p[EXTRA + k + 1])
    return (here + (x - k) * (there - here)) / math.pi


@njit
def _covered(p, k, u):
    """Cover by the facets between node k and a place u of the band behind it."""
    here, there, start = float(p[EXTRA + k]), float(p[EXTRA + k + 1]), k / BANDS
    level, slope = here + k * (here - there), BANDS * (there - here)
    return level * (_even(u) - _even(start)) + slope * (_rising(u) - _rising(start))


@njit
def _base_share(p, wo):
    """Probability of sampling the base: facets count for what they cover."""
    base = base_share(p, wo)
    either = base + (1.0 - base) * float(p[COVER])
    return base / either if either > 0.0 else 1.0


@formula
def evaluate(p, wi, wo):
    """f_d + f_s."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    h, cos_d = half(wi, wo)
    gloss = visible(h, cos_d, wi, wo) * _distribution(p, h)
    return add(coupled_base(p, wi, wo), scale(fresnel(specular_colour(p), cos_d), gloss))


@njit
def sample(p, wo, u):
    """The base with its share of the reflectance, else a facet that mirrors wo.

    The band of a facet is that where the cover passes u, its place there is found by halving.
    """
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    if u[2] < _base_share(p, wo):
        return cosine_hemisphere(u[0], u[1])
    left, k = u[0] * float(p[COVER]), 0
    band = _covered(p, 0, 1.0 / BANDS)
    while left >= band and k < BANDS - 1:
        left -= band
        k += 1
        band = _covered(p, k, (k + 1) / BANDS)
    low, high = k / BANDS, (k + 1) / BANDS
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        if _covered(p, k, middle) < left:
            low = middle
        else:
            high = middle
    v = high**4  # 1 - cos θ_h
    r, phi = math.sqrt(max(0.0, v * (2.0 - v))), 2.0 * math.pi * u[1]
    return reflect(wo, (r * math.cos(phi), r * math.sin(phi), 1.0 - v))


@njit
def pdf(p, wi, wo):
    """Base: cos θ_i / π. Facets: D cos θ_h / (4 wo·h), over what they cover."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    base, covered = _base_share(p, wo), float(p[COVER])
    density = base * wi[2] / math.pi
    if covered > 0.0:
        h, cos_d = half(wi, wo)
        facets = _distribution(p, h) * h[2] / max(1e-30, 4.0 * cos_d * covered)
        density += (1.0 - base) * facets
    return density
