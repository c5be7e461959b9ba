"""The matt surface that reflects as much as a material: what later bounces see of it.

`brdf_editing` (Ben-Artzi, Egan, Ramamoorthi, Durand 2008), appendix B: the power that leaves under
even light (eq. 36) is linear in the colours and curves of the layers, so that

    d = 1/π Σ_j c_j e_j                                                                    (eq. 37)

with e_j from a dense quadrature, once for a way to cut a model and what its quotients keep.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.base import without_grain
from engine.brdf.curve_basis import Basis, weights_at
from engine.brdf.half_angle import angle_of
from engine.brdf.layers import CONSTANTS, CURVES, LAYERS, Layers, direction_at, factors

VIEWS, TURNS = 12, 4  # heights of wo, and azimuths in a quarter of the circle
KEPT = 256
PER_BAND, ROUND = 4, 64  # angles in each band, and azimuths


class Shares(NamedTuple):
    """e_j / π: albedos of the quotients alone.

    constants  (constants,) float64
    curves     (curves, count) float64   of each element of the basis
    """

    constants: NDArray[np.float64]
    curves: NDArray[np.float64]

    def albedo(
        self, colours: NDArray[np.float64], curves: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """(3,): d of colours and curves as those of `curve_basis.coefficients`."""
        return self.constants @ colours + np.einsum("lj,ljc->c", self.curves, curves)


def shares(cut: int, p: NDArray[np.float32], count: int, basis: Basis) -> Shares:
    """Those of the quotients that p makes; see `layers` and `curve_basis`."""
    layers = LAYERS[cut]
    assert layers is not None
    known = (cut, layers.held(p), count, basis)
    if known not in _KNOWN:
        if len(_KNOWN) >= KEPT:  # a held number may be anything
            _KNOWN.clear()
        _KNOWN[known] = _integrated(layers, cut, without_grain(p[None])[0], count, basis)
    return _KNOWN[known]


_KNOWN: dict[tuple[int, float, int, Basis], Shares] = {}


def _integrated(
    layers: Layers, cut: int, p: NDArray[np.float32], count: int, basis: Basis
) -> Shares:
    s, height = _gauss(VIEWS)
    cosine, solid = angles(count)
    constants, curves = np.zeros(CONSTANTS), np.zeros((CURVES, count))
    _integrate(
        cut, p, basis == "tents", layers.mirrored, s, height, cosine, solid, constants, curves,
    )  # fmt: skip
    return Shares(constants[: layers.constants], curves[: layers.curves])


def angles(count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(cos γ, sin γ dγ): a quadrature fine enough for `count` elements."""
    u, width = _gauss(PER_BAND * count)
    return np.cos(angle_of(u)), 4 * u**3 * width


def _gauss(n: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points and weights on [0, 1]."""
    nodes, weights = np.polynomial.legendre.leggauss(n)
    return 0.5 * (nodes + 1), 0.5 * weights


@njit(cache=True, nogil=True)
def _integrate(cut, p, tents, mirrored, s, height, cosine, solid, constants, curves):
    """Sum up both; solid (n,) is sin γ dγ about the cosines (n,) of angles γ."""
    step = 2.0 * np.pi / ROUND
    for v in range(s.shape[0]):
        for turn in range(TURNS):
            azimuth = (turn + 0.5) * 0.5 * np.pi / TURNS
            r, z = np.sqrt(s[v]), np.sqrt(1.0 - s[v])
            wo = (r * np.cos(azimuth), r * np.sin(azimuth), z)
            weight = height[v] / TURNS
            # Even light has a cosine of sin² that is even too.
            for i in range(s.shape[0]):
                for k in range(ROUND):
                    r, z = np.sqrt(s[i]), np.sqrt(1.0 - s[i])
                    wi = (r * np.cos(k * step), r * np.sin(k * step), z)
                    f = factors(cut, p, wi, wo)
                    for q in range(CONSTANTS):
                        constants[q] += weight * 0.5 * height[i] * step * f[1 + q]
            # Directions about what γ is measured from.
            for i in range(cosine.shape[0]):
                for k in range(ROUND):
                    d, jacobian = direction_at(cosine[i], (k + 0.5) * step, wo, mirrored)
                    area = solid[i] * step * jacobian
                    if d[2] <= 0.0 or area <= 0.0:
                        continue
                    f = factors(cut, p, d, wo)
                    j, here, there = weights_at(f[0], curves.shape[1], tents)
                    for q in range(CURVES):
                        value = weight * area * d[2] * f[1 + CONSTANTS + q]
                        curves[q, j] += here * value
                        if there > 0.0:
                            curves[q, j + 1] += there * value
