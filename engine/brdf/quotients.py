"""Quotients of the BRDFs: what stands while colours and curves of `layers` are edited.

`brdf_editing` (Ben-Artzi, Egan, Ramamoorthi, Durand 2008), appendix A. Each kernel is

    (p, wi, wo) -> (u, q0, q1, q2, g0, g1)

where γ lies between 0 and 1, see `half_angle`, the quotients of the constants and those of the
curves, 0 for those that a model has not. p is the row of the material when it was taken in hand;
wi and wo are local.
"""

from __future__ import annotations

import math

from engine.brdf import ashikhmin_shirley, cook_torrance, ggx
from engine.brdf.base import EXTRA, ROUGHNESS, half, to_grain
from engine.brdf.fresnel import rise
from engine.brdf.half_angle import place_of
from engine.numerics.dispatch import formula
from engine.numerics.vec import dot

LEAST = 1e-3  # n_u where it is less, so that it has a ratio


@formula
def matt(p, wi, wo):
    """A matt surface."""
    return (0.0, 1.0 / math.pi, 0.0, 0.0, 0.0, 0.0)


@formula
def phong(p, wi, wo):
    """γ is the angle to the mirrored view."""
    cosine = min(1.0, dot((-wo[0], -wo[1], wo[2]), wi))
    lobe = 1.0 if cosine > 0.0 else 0.0
    return (place_of(max(0.0, cosine)), 1.0 / math.pi, 0.0, 0.0, lobe, 0.0)


@formula
def blinn_phong(p, wi, wo):
    """γ is the half angle."""
    h, _ = half(wi, wo)
    return (place_of(h[2]), 1.0 / math.pi, 0.0, 0.0, 1.0, 0.0)


@formula
def _of_facets(visible, h, cos_d, wi, wo):
    """Facets under a base that is coupled to them; visible is G / (4 cos θ_i cos θ_o)."""
    i, o, r = rise(wi[2]), rise(wo[2]), rise(cos_d)
    return (
        place_of(h[2]),
        1.0 / math.pi,
        (i + o) / math.pi,
        i * o / math.pi,
        visible * (1.0 - r),
        visible * r,
    )


@formula
def beckmann_facets(p, wi, wo):
    """Beckmann's facets, or those of a free curve."""
    h, cos_d = half(wi, wo)
    return _of_facets(cook_torrance.visible(h, cos_d, wi, wo), h, cos_d, wi, wo)


@formula
def ggx_facets(p, wi, wo):
    """With Smith's G, which keeps its roughness."""
    h, cos_d = half(wi, wo)
    return _of_facets(ggx.visible(p, wi, wo), h, cos_d, wi, wo)


@formula
def _brushed(p, wi, wo, along, across, stands_along, stands_across):
    """The lobe's exponent is n_u along the grain and n_v across it, between them by the azimuth.

    cos γ is cos θ_h to the power `along` and `across`, of which a curve is edited, and the quotient
    has cos θ_h to the power of what stands.
    """
    h, cos_d = half(wi, wo)
    g = to_grain(p, h)
    r2 = g[0] * g[0] + g[1] * g[1]
    x = g[0] * g[0] / r2 if r2 > 0.0 else 0.5
    z = min(1.0, h[2])
    lobe = z ** (stands_along * x + stands_across * (1.0 - x))
    lobe /= 4.0 * max(1e-30, cos_d * max(wi[2], wo[2]))
    place, r = place_of(z ** (along * x + across * (1.0 - x))), rise(cos_d)
    return (place, ashikhmin_shirley.matt(wi, wo), 0.0, 0.0, lobe * (1.0 - r), lobe * r)


@formula
def brushed_in_ratio(p, wi, wo):
    """γ is the half angle as it would be without a grain: both exponents are edited as one."""
    return _brushed(p, wi, wo, 1.0, float(p[EXTRA]) / max(LEAST, float(p[ROUGHNESS])), 0.0, 0.0)


@formula
def brushed_across(p, wi, wo):
    """n_v is edited, and so the ratio: eq. 33 to 35."""
    return _brushed(p, wi, wo, 0.0, 1.0, float(p[ROUGHNESS]), 0.0)


@formula
def brushed_along(p, wi, wo):
    """The same of n_u."""
    return _brushed(p, wi, wo, 1.0, 0.0, 0.0, float(p[EXTRA]))
