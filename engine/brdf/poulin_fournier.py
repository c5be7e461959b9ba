"""Poulin-Fournier: parallel cylinders with a level floor between them, one shading the next.

Poulin and Fournier 1990, *A Model for Anisotropic Reflection*. Cylinders of radius 1 lie along the
grain x, see `base.GRAIN`, `distance` apart, and stand `height` above the floor; below 0 they are
grooves. Those that are closer than they are wide cut each other, and leave no floor. A facet of the
profile with the normal n reflects f_n = ρ_d / π + ρ_s N(e) (n·h)^e, see `blinn_phong`. Seen from
afar the surface reflects what all its facets do that both directions reach (V = 1):

    f = 1 / (cos θ_i cos θ_o A) ∫ f_n max(0, n·wi) max(0, n·wo) V dA

Facets of a cylinder lean by θ from -θ_m to θ_m. What a direction from the side of y > 0 reaches of
them follows from its angle δ above the horizon in the cross-section. V is 1 where

    raised   -δ < θ < -δ + 2 asin √(distance sin δ / 2), and on all of the floor but a shade
             2 sin² ((θ_m - δ) / 2) / sin δ wide; everywhere if δ > θ_m
    grooves  θ > θ_m - 2 δ, and on all of the floor

So both directions reach one interval of θ and one of the floor. Over θ the matt part is a closed
form, and the lobe a sum over NODES Gauss-Legendre points. They are spread over no more of the
interval than where (n·h)^e is above e⁻⁹ of its peak: 3e-5 of the lobe is lost, however narrow.

Reciprocal, and no more than ρ_d + ρ_s is reflected. Light that goes on from one facet to another is
lost: under even light, white half cylinders that touch keep 82 % of it where they are matt and 44 %
where they are gloss of exponent 50, grooves 64 % and 41 %. Level, such gloss keeps 52 %.
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
from engine.brdf.blinn_phong import GRAZING, normalisation
from engine.numerics.description import Reflectance
from engine.numerics.dispatch import formula
from engine.numerics.sampling import cosine_hemisphere, cosine_power_hemisphere
from engine.numerics.vec import add, dot, reflect, scale

FLOOR = EXTRA + 1  # of a row: width of the floor; in EXTRA is θ_m, less than 0 for grooves
NODES = 12
FAINTEST = 9.0  # -ln of the part of the lobe's peak from where it counts as nothing
WIDTH = 0.55  # scale of the logistic that is as wide as (n·h)^e, times √(e + 1)
TINY, LAST = 1e-300, 1.0 - 1e-15  # where a logistic ends
_HALF = NODES // 2
_PLACES, _WEIGHTS = (tuple(a[_HALF:].tolist()) for a in np.polynomial.legendre.leggauss(NODES))


class PoulinFournier(Material):
    """Combed hair, satin, fine threads, gramophone records.

    The cylinders run along the first texture coordinate of the surface.
    """

    gloss_is_linear = True
    type: Literal["poulin_fournier"] = "poulin_fournier"
    diffuse: Annotated[Reflectance, Field(description="ρ_d, matt reflectance of a facet")] = (
        0.5,
        0.5,
        0.5,
    )
    specular: Annotated[
        Reflectance, Field(description="ρ_s, reflectance of a facet's lobe at normal incidence")
    ] = (0.2, 0.2, 0.2)
    # Near grazing angles the value of a sharper lobe would have no digits left in a shader.
    exponent: Annotated[
        float, Field(ge=0, le=500, description="e, sharpness of a facet's lobe")
    ] = 50.0
    distance: Annotated[
        float, Field(ge=0.1, le=10, description="from axis to axis of the cylinders, in radii")
    ] = 2.0
    height: Annotated[
        float, Field(ge=-1, le=1, description="above the floor, in radii; below 0 for grooves")
    ] = 1.0

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`."""
        row = self._fill(self.diffuse, self.specular, self.exponent)
        rise = abs(self.height)
        width = min(self.distance, 2.0 * math.sqrt(rise * (2.0 - rise)))
        row[EXTRA] = math.copysign(math.asin(0.5 * width), self.height)
        row[FLOOR] = self.distance - width
        row[GRAIN] = 1.0
        return row


@njit
def _reached(edge, floor, y, z):
    """(θ from, θ to, floor in the shade): what the direction (y, z) of the cross-section reaches.

    edge is θ_m, less than 0 for grooves.
    """
    elevation = math.atan2(z, abs(y))
    if edge < 0.0:
        low, high, shade = max(edge, -edge - 2.0 * elevation), -edge, 0.0
    elif elevation >= edge:
        low, high, shade = -edge, edge, 0.0
    else:
        sine = math.sin(elevation)
        apart = floor + 2.0 * math.sin(edge)
        low = -elevation
        high = min(edge, low + 2.0 * math.asin(math.sqrt(min(1.0, 0.5 * apart * sine))))
        shade = min(floor, 2.0 * math.sin(0.5 * (edge - elevation)) ** 2 / max(1e-30, sine))
    return (low, high, shade) if y >= 0.0 else (-high, -low, shade)


@njit
def _matt(low, high, a, b):
    """∫ (n·a)(n·b) dθ from low to high, written so that narrow intervals keep their digits."""
    width, middle = high - low, 0.5 * (low + high)
    s, c = math.sin(middle), math.cos(middle)
    across = (s * a[1] + c * a[2]) * (s * b[1] + c * b[2])
    sine = math.sin(width)
    return max(0.0, sine * across + 0.5 * (width - sine) * (a[1] * b[1] + a[2] * b[2]))


@njit
def _facet(s, c, e, a, b):
    """(n·h)^e (n·a)(n·b) for n = (s, c) in the frame in which h is (0, 1)."""
    across = max(0.0, s * a[0] + c * a[1]) * max(0.0, s * b[0] + c * b[1])
    return across * math.exp(e * math.log(max(1e-30, c)))


@njit
def _lobe(low, high, e, a, b):
    """∫ (n·h)^e (n·a)(n·b) dθ from low to high."""
    h = half(a, b)[0]
    size = math.sqrt(h[1] * h[1] + h[2] * h[2])
    if size <= 0.0:
        return 0.0
    s, c = h[1] / size, h[2] / size
    # In the frame of h the normal is (sin x, cos x).
    middle = math.atan2(s, c)
    reach = math.acos(math.exp(-FAINTEST / max(0.01, e)))
    first, last = max(-reach, low - middle), min(reach, high - middle)
    if first >= last:
        return 0.0
    a = (c * a[1] - s * a[2], s * a[1] + c * a[2])
    b = (c * b[1] - s * b[2], s * b[1] + c * b[2])
    x, r = 0.5 * (first + last), 0.5 * (last - first)
    s, c = math.sin(x), math.cos(x)
    total = 0.0
    for k in range(_HALF):
        sk, ck = math.sin(r * _PLACES[k]), math.cos(r * _PLACES[k])
        total += _WEIGHTS[k] * (
            _facet(s * ck + c * sk, c * ck - s * sk, e, a, b)
            + _facet(s * ck - c * sk, c * ck + s * sk, e, a, b)
        )
    return total * r * size**e


@njit
def _profile(edge, floor, e, a, b):
    """(matt, lobe): what each reflects of directions of the grain's frame, over its colour."""
    low, high, shade = _reached(edge, floor, a[1], a[2])
    low_b, high_b, shade_b = _reached(edge, floor, b[1], b[2])
    low, high = max(low, low_b), min(high, high_b)
    level = (
        a[2]
        * b[2]
        * max(0.0, floor - (max(shade, shade_b) if a[1] * b[1] >= 0.0 else shade + shade_b))
    )
    matt, gloss = level, level * max(0.0, half(a, b)[0][2]) ** e
    if low < high:
        matt += _matt(low, high, a, b)
        gloss += _lobe(low, high, e, a, b)
    unit = 1.0 / max(1e-30, a[2] * b[2] * (floor + 2.0 * math.sin(abs(edge))))
    return matt * unit / math.pi, gloss * unit * normalisation(e)


@formula
def evaluate(p, wi, wo):
    """f, of facets that both directions reach."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    matt, gloss = _profile(
        float(p[EXTRA]), float(p[FLOOR]), float(p[ROUGHNESS]), to_grain(p, wi), to_grain(p, wo)
    )
    return add(scale(diffuse_colour(p), matt), scale(specular_colour(p), gloss))


@njit
def _parts(p, wo):
    """(base, floor): probabilities of sampling the matt part, and of the rest the floor's lobe."""
    edge, floor = float(p[EXTRA]), float(p[FLOOR])
    w = to_grain(p, wo)
    low, high, shade = _reached(edge, floor, w[1], w[2])
    arc = w[1] * (math.cos(low) - math.cos(high)) + w[2] * (math.sin(high) - math.sin(low))
    level = w[2] * (floor - shade)
    part = level / (level + arc) if level > 0.0 else 0.0
    return share(diffuse_colour(p), specular_colour(p)), part


@njit
def _spread(p, wo):
    """(middle, L, s) of the half vectors' azimuth about the grain.

    The azimuth η is that of a facet, evenly over all that wo reaches, plus a logistic of the scale
    s: its distribution is C(x) = log((1 + e^(x + L/2)) / (1 + e^(x - L/2))) / L, where x is
    (η - middle) / s.
    """
    w = to_grain(p, wo)
    low, high, _ = _reached(float(p[EXTRA]), float(p[FLOOR]), w[1], w[2])
    s = WIDTH / math.sqrt(float(p[ROUGHNESS]) + 1.0)
    return 0.5 * (low + high), max(1e-9, (high - low) / s), s


@njit
def _below(x, span):
    """C(x)."""
    return math.log1p(2.0 * math.sinh(0.5 * span) / (math.exp(-x) + math.exp(-0.5 * span))) / span


@njit
def sample(p, wo, u):
    """The matt part with its share of the reflectance, else a half vector that mirrors wo.

    Of a cylinder's lobes h has the x component of a logistic, and the azimuth of `_spread`.
    """
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    base, floor = _parts(p, wo)
    if u[2] < base:
        return cosine_hemisphere(u[0], u[1])
    if u[2] < base + (1.0 - base) * floor:
        h = cosine_power_hemisphere(u[0], u[1], float(p[ROUGHNESS]))
    else:
        middle, span, s = _spread(p, wo)
        first = _below((-0.5 * math.pi - middle) / s, span)
        last = _below((0.5 * math.pi - middle) / s, span)
        y = first + u[0] * (last - first)
        ratio = math.sinh(0.5 * span * y) / max(TINY, math.sinh(0.5 * span * (1.0 - y)))
        azimuth = middle + s * math.log(max(TINY, ratio))
        azimuth = max(-0.5 * math.pi, min(0.5 * math.pi, azimuth))
        most = math.tanh(0.5 / s)
        x = 2.0 * s * math.atanh(max(-LAST, min(LAST, (2.0 * u[1] - 1.0) * most)))
        x = max(-1.0, min(1.0, x))
        r = math.sqrt(1.0 - x * x)
        h = from_grain(p, (x, r * math.sin(azimuth), r * math.cos(azimuth)))
    if dot(wo, h) <= GRAZING:
        return (0.0, 0.0, 0.0)
    return reflect(wo, h)


@njit
def pdf(p, wi, wo):
    """Base: cos θ_i / π. Lobes: that of the half vectors, dh = dx dη, / (4 wo·h)."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    base, floor = _parts(p, wo)
    density = base * wi[2] / math.pi
    h, cos_d = half(wi, wo)
    if cos_d <= GRAZING:
        return density
    e = float(p[ROUGHNESS])
    lobes = floor * (e + 1.0) / (2.0 * math.pi) * min(1.0, h[2]) ** e
    middle, span, s = _spread(p, wo)
    first = _below((-0.5 * math.pi - middle) / s, span)
    last = _below((0.5 * math.pi - middle) / s, span)
    g = to_grain(p, h)
    x = (math.atan2(g[1], g[2]) - middle) / s
    azimuth = math.sinh(0.5 * span) / (math.cosh(x) + math.cosh(0.5 * span)) / (span * s)
    along = 1.0 / (4.0 * s * math.tanh(0.5 / s) * math.cosh(0.5 * g[0] / s) ** 2)
    lobes += (1.0 - floor) * along * azimuth / (last - first)
    return density + (1.0 - base) * lobes / (4.0 * cos_d)
