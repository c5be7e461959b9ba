"""BRDFs as sums of products of two maps: one of the incident, one of the view direction.

`glossy_prt` (Wang, Tran, Luebke 2006), eq. 1, every channel by itself:

    f(wi, wo) ≈ Σ_k g_k(wi) h_k(wo)

g_k are the *light maps*, h_k the *view maps*; `engine.numerics.hemisphere_maps` says where on them
a direction lies. Directions are local; of anisotropic materials x runs along the grain. A sum of
such sums is another, so materials that a texture varies are combinations (`joined`) whose view maps
the texture scales, term by term.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from engine.numerics.hemisphere_maps import look_up


@dataclass(frozen=True, eq=False)
class Factored:
    """K terms.

    light, view  (n, n, K, 3) float32   light maps g_k and view maps h_k; rows are y, columns x
    polar        which parametrisation
    """

    light: NDArray[np.float32]
    view: NDArray[np.float32]
    polar: bool = False

    @property
    def terms(self) -> int:
        """K."""
        return self.light.shape[2]

    def first(self, terms: int) -> Factored:
        """The first so many terms alone."""
        return Factored(self.light[:, :, :terms], self.view[:, :, :terms], self.polar)


def constant(reflectance: ArrayLike) -> Factored:
    """The one exact term of Lambert's model: maps of one texel. reflectance (3,), linear RGB."""
    light = np.asarray(reflectance, np.float32).reshape(1, 1, 1, 3) / np.float32(np.pi)
    return Factored(light, np.ones((1, 1, 1, 3), np.float32))


def light_vector(factored: Factored, wi: NDArray[np.floating]) -> NDArray[np.float64]:
    """g_k(wi) of directions (q, 3): (q, K, 3). Of z ≤ 0 it is 0."""
    return _vector(factored.light, factored.polar, wi)


def view_vector(factored: Factored, wo: NDArray[np.floating]) -> NDArray[np.float64]:
    """h_k(wo) of directions (q, 3): (q, K, 3). Of z ≤ 0 it is 0."""
    return _vector(factored.view, factored.polar, wo)


def _vector(maps: NDArray[np.float32], polar: bool, w: NDArray[np.floating]) -> NDArray[np.float64]:
    size, terms = maps.shape[0], maps.shape[2]
    found = look_up(maps.reshape(size, size, 3 * terms), w, polar=polar)
    found[np.asarray(w)[:, 2] <= 0] = 0
    return found.reshape(len(w), terms, 3)


def evaluate(
    factored: Factored, wi: NDArray[np.floating], wo: NDArray[np.floating]
) -> NDArray[np.float64]:
    """The sum over the terms, sr⁻¹: (q, 3) of pairs of directions (q, 3)."""
    light, view = light_vector(factored, wi), view_vector(factored, wo)
    return np.einsum("qkc,qkc->qc", light, view)


def joined(*parts: Factored) -> Factored:
    """The sum of parts, with the terms of all of them in their order.

    A texture that scales one part scales its share of the view vector. Maps of one texel go with
    any other; those of more have one size and parametrisation.
    """
    size = max(part.light.shape[0] for part in parts)
    wide = [part for part in parts if part.light.shape[0] > 1]
    if any(part.light.shape[0] != size or part.polar != wide[0].polar for part in wide):
        raise ValueError("parts with maps of different sizes or parametrisations cannot be joined")

    def all_of(maps: list[NDArray[np.float32]]) -> NDArray[np.float32]:
        return np.concatenate(
            [np.broadcast_to(m, (size, size, *m.shape[2:])) for m in maps], axis=2
        )

    return Factored(
        all_of([part.light for part in parts]),
        all_of([part.view for part in parts]),
        bool(wide) and wide[0].polar,
    )
