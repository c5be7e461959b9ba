"""Lafortune: up to three generalised cosine lobes per channel over a diffuse base.

Lafortune, Foo, Torrance, Greenberg 1997, *Non-Linear Approximation of Reflectance Functions*, eq. 6
with C_x = C_y, per channel:

    f = ρ_d / π + ρ_s Σ_l max(0, C_xy (wi_x wo_x + wi_y wo_y) + C_z wi_z wo_z)^n

C_xy < 0 makes a lobe reflect forward (-1, 1 is Phong's mirror), |C_z| < |C_xy| leans it towards
grazing angles, and (C_xy, C_z) > 0 sends light back. With V = (C_xy wo_x, C_xy wo_y, C_z wo_z) a
lobe is |V|^n cosⁿ of the angle between V and wi, and is sampled so. ρ_s is ours: a colour or
texture that dims the lobes, 1 for published fits. Reciprocal. Nothing keeps its albedo below 1 but
the fit.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.brdf.base import Material, diffuse_colour, luminance, specular_colour
from engine.numerics.description import Description, Reflectance
from engine.numerics.dispatch import formula
from engine.numerics.frames import tangents, to_world
from engine.numerics.sampling import cosine_hemisphere, cosine_power_hemisphere
from engine.numerics.vec import add, dot, mul, scale

MOST_LOBES = 3
LOBES = 6  # nine places a lobe from here on: C_xy, C_z, n of red, green, blue each
HIGHEST = 1e5  # sr⁻¹, peak of a lobe
FAINT = 1e-100  # sr⁻¹, below which nothing is reflected: densities must not become 0 first

Coefficient = Annotated[float, Field(ge=-10, le=10)]
Exponent = Annotated[float, Field(ge=1, le=1000)]


class Lobe(Description):
    """One lobe, its three numbers for red, green and blue."""

    xy: Annotated[
        tuple[Coefficient, Coefficient, Coefficient],
        Field(description="C_xy; negative ones reflect forward"),
    ]
    z: Annotated[tuple[Coefficient, Coefficient, Coefficient], Field(description="C_z")]
    exponent: Annotated[tuple[Exponent, Exponent, Exponent], Field(description="n, sharpness")]

    @model_validator(mode="after")
    def _has_a_peak(self) -> Lobe:
        for xy, z, n in zip(self.xy, self.z, self.exponent, strict=True):
            if max(abs(xy), abs(z)) > HIGHEST ** (1 / n):
                raise ValueError(
                    f"this lobe peaks at {max(abs(xy), abs(z)):g}^{n:g} sr⁻¹, above {HIGHEST:g}: "
                    "coefficients of sharp lobes are close to 1"
                )
        return self


class Lafortune(Material):
    """Clay, skin, paint and other fits to measurements."""

    gloss_is_linear = True
    type: Literal["lafortune"] = "lafortune"
    diffuse: Annotated[Reflectance, Field(description="ρ_d, reflectance of the base")] = (
        0.5,
        0.5,
        0.5,
    )
    specular: Annotated[Reflectance, Field(description="ρ_s, which multiplies the lobes")] = (
        1.0,
        1.0,
        1.0,
    )
    # By default Phong's lobe of exponent 20 that reflects 0.2.
    lobes: Annotated[tuple[Lobe, ...], Field(max_length=MOST_LOBES)] = (
        Lobe(xy=(-0.9823,) * 3, z=(0.9823,) * 3, exponent=(20.0,) * 3),
    )

    def row(self) -> NDArray[np.float32]:
        """See `Material.row`."""
        row = self._fill(self.diffuse, self.specular if self.lobes else (0.0, 0.0, 0.0))
        for index, lobe in enumerate(self.lobes):
            first = LOBES + 9 * index
            row[first : first + 9] = (*lobe.xy, *lobe.z, *lobe.exponent)
        return row


@formula
def _lobe(p, k):
    """(C_xy, C_z, n) of lobe k // 3, channel k % 3."""
    first = LOBES + 9 * (k // 3) + k % 3
    return float(p[first]), float(p[first + 3]), float(p[first + 6])


@formula
def _gloss(p, channel, across, along):
    """Σ over the lobes of one channel."""
    total = 0.0
    for index in range(MOST_LOBES):
        xy, z, n = _lobe(p, 3 * index + channel)
        base = xy * across + z * along
        value = base**n if base > 0.0 else 0.0
        if value > FAINT:
            total += value
    return total


@formula
def evaluate(p, wi, wo):
    """Eq. 6."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    across, along = wi[0] * wo[0] + wi[1] * wo[1], wi[2] * wo[2]
    gloss = (
        _gloss(p, 0, across, along),
        _gloss(p, 1, across, along),
        _gloss(p, 2, across, along),
    )
    return add(scale(diffuse_colour(p), 1.0 / math.pi), mul(specular_colour(p), gloss))


@njit
def _axis(p, k, wo):
    """(V / |V|, weight), 0 where there is no lobe: roughly the luminance that it reflects.

    That is |V|^n 2π / (n + 1) times a mean cosine. A lobe about a direction below the surface is
    sampled about the horizon, where it is never above what is sampled.
    """
    xy, z, n = _lobe(p, k)
    v = (xy * wo[0], xy * wo[1], max(0.0, z) * wo[2])
    length = math.sqrt(dot(v, v))
    if length <= 0.0:
        return (0.0, 0.0, 1.0), 0.0
    gloss = specular_colour(p)
    colour = (
        gloss[0] if k % 3 == 0 else 0.0,
        gloss[1] if k % 3 == 1 else 0.0,
        gloss[2] if k % 3 == 2 else 0.0,
    )
    axis = scale(v, 1.0 / length)
    cosine = min(1.0, math.sqrt(axis[2] * axis[2] + 1.0 / (n + 1.0)))
    return axis, luminance(colour) * length**n * 2.0 * math.pi / (n + 1.0) * cosine


@njit
def sample(p, wo, u):
    """The base or one lobe of one channel, each with its share of the reflectance."""
    if wo[2] <= 0.0:
        return (0.0, 0.0, 0.0)
    base = luminance(diffuse_colour(p))
    total = base
    for k in range(3 * MOST_LOBES):
        total += _axis(p, k, wo)[1]
    left = u[2] * total - base
    for k in range(3 * MOST_LOBES):
        axis, weight = _axis(p, k, wo)
        if 0.0 <= left < weight:
            s, t = tangents(axis)
            n = _lobe(p, k)[2]
            return to_world(cosine_power_hemisphere(u[0], u[1], n), s, t, axis)
        left -= weight if left >= 0.0 else 0.0
    return cosine_hemisphere(u[0], u[1])


@njit
def pdf(p, wi, wo):
    """Base: cos θ_i / π. Lobes: (n + 1) / 2π · cosⁿ of the angle to V."""
    if wi[2] <= 0.0 or wo[2] <= 0.0:
        return 0.0
    base = luminance(diffuse_colour(p))
    total, density = base, base * wi[2] / math.pi
    for k in range(3 * MOST_LOBES):
        axis, weight = _axis(p, k, wo)
        total += weight
        cosine = min(1.0, dot(axis, wi))
        if weight > 0.0 and cosine > 0.0:
            n = _lobe(p, k)[2]
            density += weight * (n + 1.0) / (2.0 * math.pi) * cosine**n
    return density / total if total > 0.0 else wi[2] / math.pi
