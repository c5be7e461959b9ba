"""The transform of a hemisphere of outgoing directions: mean and log-ratio, energy kept exactly.

The paper's (§4.2) is Haar's of the logarithm: the halves of a cell are l ± h, where l is the mean
of their logarithms. So a coarser level holds geometric means, which are less than the light that
the cell reflects, and the scene darkens with distance. Ours divides the same cells in the same
order, but keeps what they reflect: with A, B what the halves reflect of light from one direction,

    M = A + B,    d = log(a / b),    A = M / (1 + e), B = M e / (1 + e),   e = w_b / w_a · e⁻ᵈ

where a = A / w_a is the mean value in a half of projected solid angle w_a, so that d = 0 where the
BRDF is even. Coefficients are log-ratios as the paper's 2 h are, and are quantised, cut into tiles
and looked up like those. Whatever coefficients are left out or rounded, no energy is lost and no
value is negative, and going down from the root by the odds A : B samples the lobe.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.brdf.wavelet import layout
from engine.numerics.tangent_poles import phi_weights, theta_weights

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Grid:
    """Where values are sampled.

    symmetry            layout.GENERAL, ORTHOTROPIC or ISOTROPIC
    theta_bits          log2 of the cells of outgoing directions along θ
    phi_bits            along φ; of the half with y > 0 where the symmetry is ISOTROPIC, and both
                        of the quarter with x, y > 0 where it is ORTHOTROPIC
    across              incident directions along θ; if ISOTROPIC from the normal to the horizon
    down                along φ; 1 if ISOTROPIC
    """

    symmetry: int
    theta_bits: int
    phi_bits: int
    across: int
    down: int

    @property
    def cells(self) -> tuple[int, int]:
        """Outgoing cells along θ and φ."""
        return 1 << self.theta_bits, 1 << self.phi_bits

    @property
    def extent(self) -> tuple[float, float]:
        """Ends of θ and φ of the outgoing cells, in halves of a turn."""
        return (
            0.5 if self.symmetry == layout.ORTHOTROPIC else 1.0,
            1.0 if self.symmetry == layout.GENERAL else 0.5,
        )

    @property
    def weights(self) -> tuple[Array, Array]:
        """Shares of the projected solid angle, of the cells along θ and along φ."""
        theta = theta_weights(self.cells[0], self.extent[0])
        phi = phi_weights(self.cells[1], self.extent[1])
        return theta / theta.sum(), phi / phi.sum()

    @property
    def incident_weights(self) -> Array:
        """(down, across): shares of the projected solid angle of the incident directions."""
        if self.symmetry == layout.ISOTROPIC:
            weight = np.sin(2 * np.arange(self.across) * np.pi / (2 * self.across - 1))[None]
            weight[0, 0] = 0.25 * weight[0, 1]
        else:
            weight = np.multiply.outer(phi_weights(self.down), theta_weights(self.across))
        return weight / weight.sum()

    def axes(self) -> list[int]:
        """Which angle each split cuts, from the root down: 0 is θ, 1 is φ."""
        return layout.schedule(self.theta_bits, self.phi_bits)[0][:, 0].tolist()


def analyse(values: NDArray[np.floating], grid: Grid) -> tuple[Array, Array, Array]:
    """(mean (...), log-ratios (nodes, ...), parts (nodes, ...)) of positive values (θ, φ, ...).

    The part of a node is what it reflects of all that is reflected. Nodes are in the order of the
    heap, from 1 on.
    """
    w = np.multiply.outer(*grid.weights)
    axes = grid.axes()
    found: list[Array] = []
    parts: list[Array] = []
    reflected = np.asarray(values, np.float64) * _as(w, values)
    for depth in reversed(range(len(axes))):
        a, b = _halves(reflected, axes[depth])
        wa, wb = _halves(w, axes[depth])
        d = np.log((a / _as(wa, a)) / (b / _as(wb, b)))
        reflected, w = a + b, wa + wb
        for values, kept in ((d, found), (reflected, parts)):
            by_node = np.zeros((1 << depth, *d.shape[2:]))
            by_node[_number(axes[:depth], wa.shape)] = values
            kept.append(by_node)
    mean = reflected[0, 0]
    return mean, np.concatenate(found[::-1]), np.concatenate(parts[::-1]) / mean


def synthesise(mean: Array, ratios: Array, grid: Grid, depth: int | None = None) -> Array:
    """Values (θ, φ, ...) of a mean and log-ratios: the inverse; above the leaves after `depth`."""
    theta, phi = grid.weights
    reflected, axes = mean[None, None], grid.axes()
    w = np.ones((1, 1))
    for k, axis in enumerate(axes[:depth]):
        bits = [axes[: k + 1].count(0), axes[: k + 1].count(1)]
        below = np.multiply.outer(_sums(theta, bits[0]), _sums(phi, bits[1]))
        wa, wb = _halves(below, axis)
        d = ratios[(1 << k) - 1 + _number(axes[:k], wa.shape)]
        e = _as(wb / wa, d) * np.exp(-d)
        reflected = _joined(reflected / (1 + e), reflected * (e / (1 + e)), axis)
        w = below
    return reflected / _as(w, reflected)


def _sums(w: Array, bits: int) -> Array:
    return w.reshape(1 << bits, -1).sum(axis=1)


def _as(w: Array, like: NDArray[np.floating]) -> Array:
    return w.reshape(w.shape + (1,) * (like.ndim - 2))


def _halves(x: Array, axis: int) -> tuple[Array, Array]:
    return (x[0::2], x[1::2]) if axis == 0 else (x[:, 0::2], x[:, 1::2])


def _joined(a: Array, b: Array, axis: int) -> Array:
    shape = list(a.shape)
    shape[axis] *= 2
    return np.stack([a, b], axis=axis + 1).reshape(shape)


def _number(axes: list[int], shape: tuple[int, ...]) -> NDArray[np.int64]:
    """(θ, φ): of the nodes that so many splits lead to, the number of the one at each cell."""
    i, j = np.indices(shape)
    number, left = np.zeros(shape, np.int64), [axes.count(0), axes.count(1)]
    for axis in axes:
        left[axis] -= 1
        number = 2 * number + ((j if axis else i) >> left[axis] & 1)
    return number
