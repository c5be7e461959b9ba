"""BRDFs that are linear in what is edited: quotients that stand, times numbers and curves.

`brdf_editing` (Ben-Artzi, Egan, Ramamoorthi, Durand 2008), eq. 4, 30 to 32:

    f(wi, wo) = Σ_l a_l q_l(wi, wo) + Σ_l q_l(wi, wo) f_l(γ(wi, wo))

with the quotients q_l fixed, and the colours a_l and curves f_l made from the material's
parameters. γ is the angle between the half vector and the normal, or that between wi and the
mirrored view. What Schlick's Fresnel makes of a curve is two of them (eq. 32), times F0 and F90 so
that a texture of the specular reflectance multiplies the first, and what it leaves to a coupled
base three constants. `engine.brdf.curve_basis` holds the curves.

A row `p` that the quotients are taken from is that of the material when it was taken in hand. Of
parameters that are neither a colour nor the width of the lobe, the quotients keep the old value:
`covers` tells whether another row has the same.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf import (
    ashikhmin_shirley,
    blinn_phong,
    cook_torrance,
    diffuse,
    ggx,
    half_angle_curve,
    phong,
)
from engine.brdf.base import DIFFUSE, EXTRA, ROUGHNESS, SPECULAR, half, to_grain
from engine.brdf.fresnel import f90, rise
from engine.brdf.half_angle import place_of
from engine.brdf.table import MODELS
from engine.numerics.dispatch import along, by_index, formula
from engine.numerics.frames import tangents, to_world
from engine.numerics.vec import dot, reflect

CONSTANTS, CURVES = 3, 2  # at most, of any model
LEAST = 1e-3  # n_u where it is less, so that it has a ratio

Curves = Callable[[NDArray[np.float32], NDArray[np.float64]], NDArray[np.float64]]


def _nothing(row: NDArray[np.float32]) -> float:
    return 0.0


@dataclass(frozen=True)
class Layers:
    """How a model is cut.

    constants, curves  how many of each it has
    factors            kernel (p, wi, wo) -> (u, q0, q1, q2, g0, g1): where γ lies between 0 and 1,
                       see `half_angle`, the quotients of the constants and those of the curves
    colours            row -> (constants, 3), the a_l
    lobes              (row, θ (n,)) -> (curves, n, 3), the f_l at angles γ
    held               row -> what of it the quotients keep
    slack              how far that may be off in a picture that is looked at for a moment
    mirrored           whether γ is the angle to the mirrored view
    even               whether the first quotient is that of a matt surface, 1/π
    """

    constants: int
    curves: int
    factors: Any
    colours: Callable[[NDArray[np.float32]], NDArray[np.float64]]
    lobes: Curves
    held: Callable[[NDArray[np.float32]], float] = _nothing
    slack: float = 0.0
    mirrored: bool = False
    even: bool = True

    def covers(
        self, p: NDArray[np.float32], row: NDArray[np.float32], *, loosely: bool = False
    ) -> bool:
        """Whether quotients that were taken from p serve another row of the same model."""
        before, now = self.held(p), self.held(row)
        return math.isclose(before, now, rel_tol=1e-5) or (
            loosely and abs(before - now) <= self.slack
        )


@formula
def direction_at(cosine, azimuth, wo, mirrored):
    """(wi, dω / (sin γ dγ dφ)): the direction at an angle γ of which the cosine is given.

    0 for directions that no half vector makes; those below the surface are for the caller.
    """
    up = (-wo[0], -wo[1], wo[2]) if mirrored else (0.0, 0.0, 1.0)
    a, b = tangents(up)
    r = math.sqrt(max(0.0, 1.0 - cosine * cosine))
    d = to_world((r * math.cos(azimuth), r * math.sin(azimuth), cosine), a, b, up)
    if mirrored:
        return d, 1.0
    jacobian = 4.0 * dot(wo, d)
    return reflect(wo, d), max(0.0, jacobian)


@formula
def _matt(p, wi, wo):
    return (0.0, 1.0 / math.pi, 0.0, 0.0, 0.0, 0.0)


@formula
def _phong(p, wi, wo):
    cosine = min(1.0, dot((-wo[0], -wo[1], wo[2]), wi))
    lobe = 1.0 if cosine > 0.0 else 0.0
    return (place_of(max(0.0, cosine)), 1.0 / math.pi, 0.0, 0.0, lobe, 0.0)


@formula
def _blinn_phong(p, wi, wo):
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
def _cook_torrance(p, wi, wo):
    h, cos_d = half(wi, wo)
    return _of_facets(cook_torrance.visible(h, cos_d, wi, wo), h, cos_d, wi, wo)


@formula
def _ggx(p, wi, wo):
    h, cos_d = half(wi, wo)
    return _of_facets(ggx.visible(p, wi, wo), h, cos_d, wi, wo)


@formula
def _ashikhmin_shirley(p, wi, wo):
    """γ is the half angle as it would be without a grain: cos γ = cos θ_h to the power e / n_u."""
    h, cos_d = half(wi, wo)
    g = to_grain(p, h)
    x, y = g[0] * g[0], g[1] * g[1]
    ratio = float(p[EXTRA]) / max(LEAST, float(p[ROUGHNESS]))
    power = (x + ratio * y) / (x + y) if x + y > 0.0 else 1.0
    matt = ashikhmin_shirley.matt(wi, wo)
    lobe = 1.0 / (4.0 * max(1e-30, cos_d * max(wi[2], wo[2])))
    r = rise(cos_d)
    return (place_of(min(1.0, h[2]) ** power), matt, 0.0, 0.0, lobe * (1.0 - r), lobe * r)


def _diffuse_of(row: NDArray[np.float32]) -> NDArray[np.float64]:
    return row[None, DIFFUSE : DIFFUSE + 3].astype(np.float64)


def _no_lobes(row: NDArray[np.float32], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.zeros((0, len(theta), 3))


def _specular(row: NDArray[np.float32]) -> NDArray[np.float64]:
    return row[SPECULAR : SPECULAR + 3].astype(np.float64)


def _grazing(row: NDArray[np.float32]) -> NDArray[np.float64]:
    """(3,): F90."""
    return np.full(3, f90.py_func(_specular(row)))


def _power_lobe(
    row: NDArray[np.float32], theta: NDArray[np.float64], unit: float
) -> NDArray[np.float64]:
    lobe = unit * np.cos(theta) ** float(row[ROUGHNESS])
    return (lobe[:, None] * _specular(row))[None]


def _phong_lobe(row: NDArray[np.float32], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    return _power_lobe(row, theta, (float(row[ROUGHNESS]) + 2) / (2 * np.pi))


def _blinn_lobe(row: NDArray[np.float32], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    return _power_lobe(row, theta, blinn_phong.normalisation.py_func(float(row[ROUGHNESS])))


def _under_fresnel(row: NDArray[np.float32], lobe: NDArray[np.float64]) -> NDArray[np.float64]:
    """(2, n, 3): F0 and F90 times a lobe (n,), eq. 32."""
    return np.stack([lobe[:, None] * _specular(row), lobe[:, None] * _grazing(row)])


def _beckmann_lobe(row: NDArray[np.float32], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    m2, z = max(cook_torrance.MIN_SLOPE, float(row[ROUGHNESS])) ** 2, np.cos(theta)
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        tangent2 = np.minimum(np.tan(theta) ** 2 / m2, cook_torrance.STEEPEST)
        lobe = np.exp(-tangent2) / (np.pi * m2 * z**4)
    return _under_fresnel(row, np.where(tangent2 < cook_torrance.STEEPEST, lobe, 0))


def _ggx_lobe(row: NDArray[np.float32], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    a2 = max(ggx.MIN_ALPHA, float(row[ROUGHNESS]) ** 2) ** 2
    lobe = a2 / (np.pi * (a2 * np.cos(theta) ** 2 + np.sin(theta) ** 2) ** 2)
    return _under_fresnel(row, lobe)


def _brushed_lobe(row: NDArray[np.float32], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    nu, nv = float(row[ROUGHNESS]), float(row[EXTRA])
    unit = math.sqrt((nu + 1) * (nv + 1)) / (2 * np.pi)
    return _under_fresnel(row, unit * np.cos(theta) ** max(LEAST, nu))


def _free_lobe(row: NDArray[np.float32], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    curve = row[EXTRA : half_angle_curve.COVER]
    places = np.sqrt(np.sqrt(1 - np.cos(theta)))
    lobe = np.interp(places, np.linspace(0, 1, len(curve)), curve) / np.pi
    return _under_fresnel(row, lobe)


def _ratio(row: NDArray[np.float32]) -> float:
    return float(row[EXTRA]) / max(LEAST, float(row[ROUGHNESS]))


def _coupled_colours(row: NDArray[np.float32]) -> NDArray[np.float64]:
    """(3, 3): of 1, s_i + s_o and s_i s_o, from the product of what either direction passes."""
    passed, rise = 1 - _specular(row), _grazing(row) - _specular(row)
    unit = row[DIFFUSE : DIFFUSE + 3] / np.maximum(1e-9, passed - rise / 21)
    return unit * np.stack([passed**2, -passed * rise, rise**2])


def _brushed_colours(row: NDArray[np.float32]) -> NDArray[np.float64]:
    return _diffuse_of(row) * (1 - _specular(row))


_LAYERS: dict[ModuleType, Layers] = {
    diffuse: Layers(1, 0, _matt, _diffuse_of, _no_lobes),
    phong: Layers(1, 1, _phong, _diffuse_of, _phong_lobe, mirrored=True),
    blinn_phong: Layers(1, 1, _blinn_phong, _diffuse_of, _blinn_lobe),
    # Smith's G knows the roughness, and follows it slowly.
    ggx: Layers(3, 2, _ggx, _coupled_colours, _ggx_lobe, lambda row: float(row[ROUGHNESS]), 0.2),
    cook_torrance: Layers(3, 2, _cook_torrance, _coupled_colours, _beckmann_lobe),
    half_angle_curve: Layers(3, 2, _cook_torrance, _coupled_colours, _free_lobe),
    ashikhmin_shirley: Layers(
        1, 2, _ashikhmin_shirley, _brushed_colours, _brushed_lobe, _ratio, even=False
    ),
}

LAYERS: tuple[Layers | None, ...] = tuple(_LAYERS.get(module) for module in MODELS.values())
"""By the index of the model; None for models that are not cut."""

_FACTORS = [(layers or _LAYERS[diffuse]).factors for layers in LAYERS]
factors = by_index(_FACTORS, 3)
factors_along = by_index([along(f) for f in _FACTORS], 7)
