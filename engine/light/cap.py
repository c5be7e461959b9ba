"""What a cone of even radiance gives a surface: the irradiance of a ball and of the sun.

With θ the angle from the normal to the cone's axis and σ its half angle, all of it is seen up to
θ = π/2 - σ, and E = π L sin²σ cos θ. Beyond that the horizon cuts it, and with
w = √(sin²σ - cos²θ)

    E = L (sin²σ cos θ atan2(w, -cos θ cos σ) - w cos σ + atan(w / cos σ)),

the integral of Lambert's formula along the rim and the horizon (Snyder 1996, *Area Light Sources
for Real-Time Graphics*, in other letters).
"""

from __future__ import annotations

import math

from numba import njit

from engine.light.base import DARK, UNKNOWN, shares_plane
from engine.numerics.vec import dot


@njit
def cap_irradiance(p, axis, sine2, n, g):
    """`irradiance` of a light that fills a cone of sin²σ about a unit axis; radiance in p."""
    cosine, over = dot(n, axis), dot(g, axis)
    if min(cosine * abs(cosine), over * abs(over)) <= -sine2:
        return DARK
    if over * abs(over) < sine2 and not shares_plane(n, g):
        return UNKNOWN
    e = math.pi * sine2 * cosine
    if cosine * abs(cosine) < sine2:
        c, w = math.sqrt(1.0 - sine2), math.sqrt(sine2 - cosine * cosine)
        e = sine2 * cosine * math.atan2(w, -cosine * c) - w * c + math.atan2(w, c)
    return (p[6] * e, p[7] * e, p[8] * e)
