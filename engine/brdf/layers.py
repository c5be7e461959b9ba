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
    quotients,
)
from engine.brdf.base import DIFFUSE, EXTRA, ROUGHNESS, SPECULAR
from engine.brdf.fresnel import f90
from engine.brdf.table import MODULES
from engine.numerics.dispatch import along, by_index, formula
from engine.numerics.frames import tangents, to_world
from engine.numerics.vec import dot, reflect

CONSTANTS, CURVES = 3, 2  # at most, of any model

Curves = Callable[[NDArray[np.float32], NDArray[np.float64]], NDArray[np.float64]]


def _nothing(row: NDArray[np.float32]) -> float:
    return 0.0


@dataclass(frozen=True)
class Layers:
    """How a model is cut.

    constants, curves  how many of each it has
    factors            the kernel of its `quotients`
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
    return _exponent_lobe(row, theta, float(row[ROUGHNESS]))


def _across_lobe(row: NDArray[np.float32], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    return _exponent_lobe(row, theta, float(row[EXTRA]))


def _exponent_lobe(
    row: NDArray[np.float32], theta: NDArray[np.float64], exponent: float
) -> NDArray[np.float64]:
    unit = math.sqrt((float(row[ROUGHNESS]) + 1) * (float(row[EXTRA]) + 1)) / (2 * np.pi)
    return _under_fresnel(row, unit * np.cos(theta) ** max(quotients.LEAST, exponent))


def _free_lobe(row: NDArray[np.float32], theta: NDArray[np.float64]) -> NDArray[np.float64]:
    curve = row[EXTRA : half_angle_curve.COVER]
    places = np.sqrt(np.sqrt(1 - np.cos(theta)))
    lobe = np.interp(places, np.linspace(0, 1, len(curve)), curve) / np.pi
    return _under_fresnel(row, lobe)


def _kept(place: int) -> Callable[[NDArray[np.float32]], float]:
    return lambda row: float(row[place])


def _ratio(row: NDArray[np.float32]) -> float:
    return float(row[EXTRA]) / max(quotients.LEAST, float(row[ROUGHNESS]))


def _coupled_colours(row: NDArray[np.float32]) -> NDArray[np.float64]:
    """(3, 3): of 1, s_i + s_o and s_i s_o, from the product of what either direction passes."""
    passed, rise = 1 - _specular(row), _grazing(row) - _specular(row)
    unit = row[DIFFUSE : DIFFUSE + 3] / np.maximum(1e-9, passed - rise / 21)
    return unit * np.stack([passed**2, -passed * rise, rise**2])


def _brushed_colours(row: NDArray[np.float32]) -> NDArray[np.float64]:
    return _diffuse_of(row) * (1 - _specular(row))


_LAYERS: dict[ModuleType, Layers] = {
    diffuse: Layers(1, 0, quotients.matt, _diffuse_of, _no_lobes),
    phong: Layers(1, 1, quotients.phong, _diffuse_of, _phong_lobe, mirrored=True),
    blinn_phong: Layers(1, 1, quotients.blinn_phong, _diffuse_of, _blinn_lobe),
    # Smith's G knows the roughness, and follows it slowly.
    ggx: Layers(
        3, 2, quotients.ggx_facets, _coupled_colours, _ggx_lobe, _kept(ROUGHNESS), slack=0.2
    ),
    cook_torrance: Layers(3, 2, quotients.beckmann_facets, _coupled_colours, _beckmann_lobe),
    half_angle_curve: Layers(3, 2, quotients.beckmann_facets, _coupled_colours, _free_lobe),
    ashikhmin_shirley: Layers(
        1, 2, quotients.brushed_in_ratio, _brushed_colours, _brushed_lobe, _ratio, even=False
    ),
}
# Of its two exponents one may stand while the other is edited.
_BRUSHED = (
    Layers(
        1, 2, quotients.brushed_across, _brushed_colours, _across_lobe, _kept(ROUGHNESS), even=False
    ),
    Layers(
        1, 2, quotients.brushed_along, _brushed_colours, _brushed_lobe, _kept(EXTRA), even=False
    ),
)

LAYERS: tuple[Layers | None, ...] = (
    *(_LAYERS.get(module) for module in MODULES),
    *_BRUSHED,
)
"""Ways to cut models, the first of each by the index of the model; None where there is none."""


def cut_for(
    model: int, before: NDArray[np.float32], row: NDArray[np.float32], liked: int = -1
) -> int:
    """Which of LAYERS serves an edit of a model's row from what it was `before`.

    The one that is liked, if it does; the model's own if none does, which then is new.
    """
    ways = [model]
    if LAYERS[model] is _LAYERS[ashikhmin_shirley]:
        ways += range(len(MODULES), len(LAYERS))
    for cut in sorted(ways, key=lambda cut: cut != liked):
        layers = LAYERS[cut]
        if layers is not None and layers.covers(before, row):
            return cut
    return model


_FACTORS = [(layers or _LAYERS[diffuse]).factors for layers in LAYERS]
factors = by_index(_FACTORS, 3)
factors_along = by_index([along(f) for f in _FACTORS], 7)
