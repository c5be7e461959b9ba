"""A matt base that gets what an interface above it lets through, for models with Schlick's F.

Shirley, Smits, Hu, Lafortune 1997, *A Practitioners' Assessment of Light Reflection Models*, §5:

    f_d = ρ (1 - F(θ_i)) (1 - F(θ_o)) / (π c)

with c the cosine-weighted mean of 1 - F over the hemisphere, which for the F of `fresnel` is
1 - F0 - (F90 - F0) / 21. Reciprocal. It reflects ρ (1 - F(θ_o)); where F0 is black it is Lambert's.
"""

from __future__ import annotations

import math

from numba import njit

from engine.brdf.base import diffuse_colour, share, specular_colour
from engine.brdf.fresnel import f90, fresnel
from engine.numerics.dispatch import formula
from engine.numerics.vec import mul


@formula
def coupled_base(p, wi, wo):
    """f_d of a row for directions above the surface: ρ is its diffuse colour, F0 its specular."""
    f0 = specular_colour(p)
    grazing = f90(f0)
    # It vanishes where the interface lets nothing through.
    base = mul(diffuse_colour(p), mul(_passed(f0, wi[2]), _passed(f0, wo[2])))
    return (
        base[0] / (math.pi * max(1e-9, _mean_passed(f0[0], grazing))),
        base[1] / (math.pi * max(1e-9, _mean_passed(f0[1], grazing))),
        base[2] / (math.pi * max(1e-9, _mean_passed(f0[2], grazing))),
    )


@njit
def base_share(p, wo):
    """Probability of sampling the base: its part of the light reflected towards wo, roughly."""
    f0 = specular_colour(p)
    return share(mul(diffuse_colour(p), _passed(f0, wo[2])), fresnel(f0, wo[2]))


@formula
def _passed(f0, cosine):
    """1 - F, for a colour."""
    f = fresnel(f0, cosine)
    return (1.0 - f[0], 1.0 - f[1], 1.0 - f[2])


@formula
def _mean_passed(f0, grazing):
    """Cosine-weighted mean of 1 - F over the hemisphere, for one channel."""
    return 1.0 - f0 - (grazing - f0) / 21.0
