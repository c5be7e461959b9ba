"""BRDFs to encode: what `tabulate` takes, made of formulas."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Formula:
    """A source of a function of (wi, wo) (q, 3) -> (q, 3)."""

    value: Callable[[Array, Array], Array]
    isotropic: bool

    def evaluate(self, wi: Array, wo: Array) -> Array:
        return self.value(wi, wo)


def lobe(
    exponents: tuple[float, float, float], turn: float = 0.0
) -> Callable[[Array, Array], Array]:
    """A Gaussian of the half vector's slope, stretched unless both its numbers are one; coloured.

    The third number is how much of it there is.
    """
    across, along, amount = exponents
    c, s = np.cos(turn), np.sin(turn)

    def value(wi: Array, wo: Array) -> Array:
        h = wi + wo
        x, y = (
            (c * h[..., 0] + s * h[..., 1]) / h[..., 2],
            (c * h[..., 1] - s * h[..., 0]) / h[..., 2],
        )
        gloss = amount * np.exp(-across * x * x - along * y * y)
        return np.array([0.3, 0.2, 0.1]) / np.pi + gloss[..., None] * np.array([1.0, 0.9, 0.8])

    return value


ISOTROPIC = Formula(lobe((20, 20, 1.0)), True)
BRUSHED = Formula(lobe((5, 40, 1.0)), False)
ASKEW = Formula(lobe((5, 40, 1.0), 0.5), False)
MATT = Formula(lambda wi, wo: np.full((*wi.shape[:-1], 3), (0.1, 0.2, 0.3)), True)
SOURCES = {"isotropic": ISOTROPIC, "mirrored": BRUSHED, "general": ASKEW}


def hemisphere(rng: np.random.Generator, n: int) -> Array:
    """(n, 3) with cosine density."""
    z = np.sqrt(rng.random(n))
    phi = 2 * np.pi * rng.random(n)
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)


def near_mirror(rng: np.random.Generator, wo: Array, width: float = 0.1) -> Array:
    """(n, 3) about the mirror images of wo."""
    w = wo * (-1, -1, 1) + width * rng.normal(size=wo.shape)
    w[:, 2] = np.abs(w[:, 2]) + 1e-3
    return w / np.linalg.norm(w, axis=1, keepdims=True)
