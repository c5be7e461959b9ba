"""How well a factored BRDF fits its material: error, energy, negative light, terms needed."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf import arrays, table
from engine.brdf.albedo import hemispherical_albedo
from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.factored import Factored, light_vector, view_vector
from engine.brdf.factorisation import SIZE, brdf_matrix, eigenpairs
from engine.diagnosis import Diagnosis
from engine.numerics.hemisphere_maps import texels

PAIRS = 100_000  # what the paper uses
QUADRATURE = 96  # texels round and up the hemisphere that integrals are summed over
VIEWS = 511  # view directions that negative values are looked for from
OFF_ENERGY = 0.1  # of the albedo: beyond it texels do not resolve a lobe


class Pairs(NamedTuple):
    """Pairs of directions and the BRDF there.

    wi, wo  (q, 3) float64   unit, local
    value   (q, 3) float64   sr⁻¹
    """

    wi: NDArray[np.float64]
    wo: NDArray[np.float64]
    value: NDArray[np.float64]


class Fit(NamedTuple):
    """How well terms fit a material.

    error      cosine-weighted root mean square, as a part of that of the material
    kept       of its albedo, in the channel that keeps least
    negative   part of its light that is negative, see `negative_share`
    needed     terms that would hold a bound that the error is beyond
    tabulated  of its albedo that maps of this size hold with any number of terms
    """

    error: float
    kept: float
    negative: float
    needed: int
    tabulated: float


def uniform_pairs(material: Material, count: int = PAIRS, seed: int = 1) -> Pairs:
    """Pairs of directions that are uniform over the hemisphere, `glossy_prt` §5.2.1."""
    rng = np.random.default_rng(seed)
    z, phi = rng.random((2, count)), 2 * np.pi * rng.random((2, count))
    r = np.sqrt(1 - z * z)
    wi, wo = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1)
    value = arrays.evaluate(table.INDEX[type(material)], material.row(), wi, wo)
    return Pairs(wi, wo, value)


def rms_errors(factored: Factored, pairs: Pairs) -> tuple[NDArray[np.float64], float]:
    """Cosine-weighted root mean square errors of the first 1, 2, ... K terms, (K,), and that of 0.

    √(mean of (cos θ_i (f̂ - f))²), sr⁻¹, over pairs and channels: f with the incident cosine is what
    a light of radiance 1 and a steradian brings. The error of no terms is the RMS of f.
    """
    light, view = light_vector(factored, pairs.wi), view_vector(factored, pairs.wo)
    weighed = pairs.wi[:, 2, None] * pairs.value
    sums = np.zeros_like(weighed)
    found = []
    for k in range(factored.terms):
        sums += pairs.wi[:, 2, None] * light[:, k] * view[:, k]
        found.append(np.sqrt(np.mean((sums - weighed) ** 2)))
    return np.array(found), float(np.sqrt(np.mean(weighed**2)))


def albedo_kept(factored: Factored, material: Material) -> NDArray[np.float64]:
    """(3,): bihemispherical reflectance of the fit as a part of the material's; 1 keeps the energy.

    A channel that is black keeps all.
    """
    w, weight = _quadrature()
    light = np.einsum("qkc,q->kc", light_vector(factored, w), weight)
    view = np.einsum("qkc,q->kc", view_vector(factored, w), weight)
    fitted = (light * view).sum(axis=0) / np.pi
    return _part(fitted, material)


def _part(fitted: NDArray[np.float64], material: Material) -> NDArray[np.float64]:
    true = hemispherical_albedo(table.INDEX[type(material)], material.row())[0]
    return np.where(true > 0, fitted / np.where(true > 0, true, 1), 1.0)


def negative_share(factored: Factored) -> float:
    """How much of the light under an even sky a fit takes away where it is negative.

    ∫∫ max(0, -f̂) cos θ_i cos θ_o / ∫∫ |f̂| cos θ_i cos θ_o, all channels together: the worst that
    lights can make of it is radiance below 0, which a renderer clamps.
    """
    w, weight = _quadrature()
    some = slice(VIEWS // 2, None, max(1, len(w) // VIEWS))
    light = light_vector(factored, w) * weight[:, None, None]
    view = view_vector(factored, w[some]) * weight[some, None, None]
    below = whole = 0.0
    for c in range(3):
        f = light[:, :, c] @ view[:, :, c].T
        below += float(np.maximum(-f, 0).sum())
        whole += float(np.abs(f).sum())
    return below / whole if whole > 0 else 0.0


def _quadrature() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Directions (q, 3) and projected solid angles (q,), which sum to π."""
    grid = texels(QUADRATURE, polar=True)
    return grid.direction, np.pi * grid.weight / grid.weight.sum()


def terms_for(material: Material, error: float, size: int = SIZE) -> tuple[int, float]:
    """(K, albedo kept): the least number of terms that leave no more than a relative error out.

    Error is √(Σ_{k > K} λ_k² / Σ λ_k²), that of the matrix of texels without look-ups between them.
    The albedo of the matrix itself, as a part of the material's, is 1 where the texels are fine
    enough for the lobe; that of the channel where it is worst.
    """
    if isinstance(material, Diffuse):
        return 1, 1.0
    model, row, grid = table.INDEX[type(material)], material.row(), texels(size)
    inner = len(grid.weight)
    matrix = brdf_matrix(model, row, grid)[:, :inner]
    texel = 4 / size**2  # its projected solid angle
    most = 1
    for c in range(3):
        if any(np.array_equal(matrix[c], matrix[k]) for k in range(c)):
            continue
        values, _ = eigenpairs(matrix[c], grid, inner)
        # left[j] is what is left out without the j + 1 smallest.
        left = np.cumsum(values[::-1] ** 2)
        most = max(most, len(values) - int((left <= error**2 * left[-1]).sum()))
    kept = _part(matrix.sum(axis=(1, 2), dtype=np.float64) * texel**2 / np.pi, material)
    return most, float(kept[np.abs(kept - 1).argmax()])


def fit_of(material: Material, factored: Factored, bound: float) -> Fit:
    """How well the terms fit a material; what more terms would do is found beyond the bound only.

    Takes up to a second; the factored form is that of the material, whatever made it.
    """
    each, whole = rms_errors(factored, uniform_pairs(material))
    error = float(each[-1]) / whole if whole > 0 else 0.0
    needed, tabulated = factored.terms, 1.0
    if error > bound:
        needed, tabulated = terms_for(material, bound, factored.light.shape[0])
    kept = float(albedo_kept(factored, material).min())
    return Fit(error, kept, negative_share(factored), needed, tabulated)


def fit_diagnosis(name: str, fit: Fit, factored: Factored, bound: float) -> Diagnosis | None:
    """What to say of a fit whose error is beyond the bound; None where it is not.

    name is the material's. It names the number of terms that would hold the bound and, where maps
    of this size are too coarse for the lobe whatever their number, says so.
    """
    if fit.error <= bound:
        return None
    size = factored.light.shape[0]
    advice = f"{fit.needed} terms would hold {100 * bound:g} %"
    if abs(fit.tabulated - 1) > OFF_ENERGY:
        advice += f", but only on finer maps: {size} texels across do not resolve its highlight"
    return Diagnosis(
        "too_glossy_for_terms",
        f"Material {name!r} is too glossy for {factored.terms} terms: their fit is "
        f"{100 * fit.error:.0f} % off (RMS), highlights are too wide and dim, "
        f"{100 * fit.negative:.0f} % of its light is negative and clamped, and it keeps "
        f"{100 * fit.kept:.0f} % of its albedo; {advice}.",
        fit.error,
    )
