"""Factored BRDFs: exact where they must be, better with every term, and reciprocal."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.materials import hemisphere, model_and_row

from engine import brdf
from engine.brdf.as_curve import as_curve
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.diffuse import Diffuse
from engine.brdf.factored import Factored, constant, evaluate, joined, light_vector, view_vector
from engine.brdf.factorisation import (
    brdf_matrix,
    eigenpairs,
    factor,
    factor_parts,
)
from engine.brdf.fit import albedo_kept, negative_share, rms_errors, uniform_pairs
from engine.brdf.ggx import Ggx
from engine.brdf.non_negative import non_negative
from engine.brdf.one_term import normalised
from engine.brdf.phong import Phong
from engine.brdf.published import BRUSHED, CLAY, PUBLISHED, RED_PHONG, SKIN
from engine.numerics.hemisphere_maps import mirrors, texels

SMOOTH = Phong(diffuse=(0.3, 0.2, 0.1), specular=(0.4, 0.4, 0.4), exponent=6)
every_published = pytest.mark.parametrize("name", PUBLISHED)
either_map = pytest.mark.parametrize("polar", [False, True])


def at_texels(material: Material, factored: Factored, size: int, polar: bool) -> float:
    """Relative error at the pairs of texels, where nothing is interpolated."""
    grid = texels(size, polar=polar)
    inner = len(grid.weight)
    w = grid.direction[:inner]
    true = brdf_matrix(*model_and_row(material), grid)[:, :inner]
    fit = np.einsum("ikc,jkc->cij", light_vector(factored, w), view_vector(factored, w))
    return float(np.linalg.norm(fit - true) / np.linalg.norm(true))


def test_diffuse_is_one_exact_constant_term() -> None:
    material = Diffuse(diffuse=(0.2, 0.5, 0.9))
    factored = factor(material, terms=4)
    assert factored.terms == 1
    wi, wo = hemisphere(np.random.default_rng(1), 100), hemisphere(np.random.default_rng(2), 100)
    np.testing.assert_allclose(
        evaluate(factored, wi, wo), brdf.evaluate(*model_and_row(material), wi, wo), rtol=1e-7
    )
    for other in (normalised(material), non_negative(material)):
        np.testing.assert_array_equal(evaluate(other, wi, wo), evaluate(factored, wi, wo))


def test_separable_models_have_one_term() -> None:
    """The matrix of a BRDF that is a product has one eigenvalue, and no second term is made up."""
    base = AshikhminShirley(diffuse=(0.2, 0.5, 0.9), specular=(0.0, 0.0, 0.0))
    factored = factor(base, terms=4, size=16)
    assert factored.terms == 1
    assert at_texels(base, factored, 16, polar=False) < 1e-6


@either_map
@pytest.mark.parametrize("material", [SMOOTH, SKIN], ids=["phong", "skin"])
def test_exact_at_full_rank(material: Material, polar: bool) -> None:
    """With all eigenvectors the table comes back, sign of each eigenvalue included."""
    assert at_texels(material, factor(material, 10_000, 12, polar=polar), 12, polar) < 1e-5


@every_published
def test_error_falls_with_every_term(name: str) -> None:
    material = PUBLISHED[name]
    factored = factor(material, 12, 24)
    left = [at_texels(material, factored.first(k), 24, polar=False) for k in range(1, 13)]
    assert (np.diff(left) < 0).all()
    # First terms are as good as those of a shorter run.
    few = at_texels(material, factor(material, 3, 24), 24, polar=False)
    assert few == pytest.approx(left[2], rel=1e-3)


@pytest.mark.parametrize("name", ["red Phong", "clay", "skin"])
def test_error_falls_with_the_maps_size(name: str) -> None:
    """§5.2.1: with many terms what is left is the error of bilinear look-ups."""
    pairs = uniform_pairs(PUBLISHED[name], 20_000)
    left = [rms_errors(factor(PUBLISHED[name], 40, n), pairs)[0][-1] for n in (12, 16, 32)]
    assert left[0] > left[1] > left[2]


def test_negative_eigenvalues_keep_their_sign() -> None:
    """About half of a mirror's eigenvalues are negative: without their sign light goes back."""
    factored = factor(SMOOTH, 40, 32)
    sign = np.sign((factored.light * factored.view).sum(axis=(0, 1)))
    assert (sign == -1).any(axis=0).all()
    assert (sign == 1).any(axis=0).all()
    wo = hemisphere(np.random.default_rng(3), 400)
    wo = wo[np.hypot(wo[:, 0], wo[:, 1]) > 0.6]
    mirror = wo * (-1, -1, 1)
    true = brdf.evaluate(*model_and_row(SMOOTH), mirror, wo)
    fit = evaluate(factored, mirror, wo)
    assert np.linalg.norm(fit - true) < 0.05 * np.linalg.norm(true)
    # The same maps with the sign left out reflect towards where the light comes from instead.
    lost = Factored(factored.light, np.abs(factored.view) * np.sign(factored.light))
    assert np.linalg.norm(evaluate(lost, mirror, wo) - true) > 0.3 * np.linalg.norm(true)


def test_a_perfect_mirror_has_as_many_negative_as_positive_eigenvalues() -> None:
    """Its table exchanges texels that lie opposite: its values are 1 and -1."""
    grid = texels(8)
    inner = len(grid.weight)
    x, y = mirrors(grid)
    exchange = np.zeros((len(grid.number), inner))
    exchange[np.arange(inner), x[y]] = 1
    values, vectors = eigenpairs(exchange, grid, inner)
    np.testing.assert_allclose(np.abs(values), 1, atol=1e-12)
    assert (values < 0).sum() == inner // 2
    back = vectors[:inner] * values @ vectors[:inner].T
    np.testing.assert_allclose(back, exchange[:inner], atol=1e-12)


@either_map
def test_all_eigenvalues_are_found(polar: bool) -> None:
    """Those of pairs that are equal both, against a solver that knows nothing of mirrors."""
    grid = texels(16, polar=polar)
    inner, root = len(grid.weight), np.sqrt(grid.weight)
    matrix = brdf_matrix(*model_and_row(SKIN), grid)[0]
    values, _ = eigenpairs(matrix, grid, 20)
    dense = np.linalg.eigvalsh(matrix[:inner] * root[:, None] * root)
    dense = dense[np.argsort(-np.abs(dense))]
    np.testing.assert_allclose(values, dense[:20], rtol=1e-5)
    assert (values < 0).any()


def test_a_table_that_is_not_even_is_factored_all_the_same() -> None:
    grid = texels(8)
    inner = len(grid.weight)
    matrix = np.random.default_rng(6).normal(size=(len(grid.number), inner))
    matrix[:inner] += matrix[:inner].T
    values, vectors = eigenpairs(matrix, grid, inner)
    back = vectors * values @ vectors[:inner].T
    np.testing.assert_allclose(back, matrix, atol=1e-6)


@every_published
def test_reciprocal(name: str) -> None:
    factored = factor(PUBLISHED[name], 6, 24)
    wi, wo = hemisphere(np.random.default_rng(4), 500), hemisphere(np.random.default_rng(5), 500)
    there, back = evaluate(factored, wi, wo), evaluate(factored, wo, wi)
    np.testing.assert_allclose(there, back, rtol=1e-5, atol=1e-6)


@every_published
@pytest.mark.parametrize("terms", [1, 4, 16])
def test_energy_of_the_fit(name: str, terms: int) -> None:
    """Few terms blur a highlight; at the paper's gloss they hardly take light from it."""
    kept = albedo_kept(factor(PUBLISHED[name], terms, 32), PUBLISHED[name])
    assert kept.min() > (0.85 if terms == 1 else 0.94)
    assert kept.max() < 1.02


@pytest.mark.parametrize("size", [16, 32, 40])
def test_no_map_size_loses_the_light_to_the_horizon(size: int) -> None:
    """Near the horizon Ashikhmin-Shirley is in the thousands: with texels at the very rim, four
    terms of 32 x 32 had nothing else and kept 5 % of the albedo, of 64 x 64 not 1 %.
    """
    assert albedo_kept(factor(BRUSHED, 4, size), BRUSHED)[0] == pytest.approx(0.98, abs=0.02)


@either_map
@every_published
def test_normalised_reflects_as_much_from_everywhere(name: str, polar: bool) -> None:
    """One term, never negative, with the albedo of every incident direction."""
    material = PUBLISHED[name]
    factored = normalised(material, 32, polar=polar)
    assert factored.terms == 1
    assert factored.light.min() >= 0
    assert factored.view.min() >= 0
    np.testing.assert_allclose(albedo_kept(factored, material), 1, atol=0.025)  # of 32 texels
    # It is no worse than the eigenpair by much, which is best on texels but not on these pairs:
    # in polar maps, which reach the horizon, Ashikhmin-Shirley is 6 % better off.
    pairs = uniform_pairs(material, 20_000)
    one, best = (
        rms_errors(f, pairs)[0][0] for f in (factored, factor(material, 1, 32, polar=polar))
    )
    assert 0.92 * best < one < 1.03 * best


@pytest.mark.parametrize("name", ["red Phong", "skin"])
def test_non_negative(name: str) -> None:
    """Four terms without a negative value fit as well as four that ring, but for some percent."""
    material = PUBLISHED[name]
    factored, best = non_negative(material, 4, 16), factor(material, 4, 16)
    assert factored.light.min() >= 0
    assert factored.view.min() >= 0
    assert negative_share(factored) == 0
    pairs = uniform_pairs(material, 20_000)
    ours, least = (rms_errors(f, pairs)[0][-1] for f in (factored, best))
    assert ours < 1.05 * least
    # One such term is the first eigenvector.
    one = non_negative(material, 1, 16)
    assert rms_errors(one, pairs)[0][0] == pytest.approx(rms_errors(best, pairs)[0][0], rel=2e-3)


@pytest.mark.parametrize(
    "material",
    [
        RED_PHONG,
        SKIN,
        BRUSHED,
        Ggx(diffuse=(0.6, 0.2, 0.1), roughness=0.6),
        CookTorrance(diffuse=(0.6, 0.2, 0.1), roughness=0.6),
        as_curve(BlinnPhong(diffuse=(0.6, 0.2, 0.1), exponent=10)),
    ],
    ids=["phong", "skin", "ashikhmin-shirley", "ggx", "cook-torrance", "curve"],
)
def test_textures_scale_the_terms(material: Material) -> None:
    """Base and gloss apart, each scaled: the fit of the material with those colours."""
    base, gloss = factor_parts(material, terms=300, size=16)
    assert base.terms == 1
    grid = texels(16)
    w = grid.direction[: len(grid.weight)]
    colour = np.array([0.9, 0.4, 0.05])
    both = joined(base, gloss)
    view = view_vector(both, w)
    view[:, : base.terms] *= colour
    found = np.einsum("ikc,jkc->cij", light_vector(both, w), view)
    other = material.model_copy(update={"diffuse": tuple(colour)})
    true = brdf_matrix(*model_and_row(other), grid)[:, : len(w)]
    assert np.linalg.norm(found - true) < 1e-4 * np.linalg.norm(true)


def test_joined_parts_must_fit() -> None:
    wide = factor(SMOOTH, 2, 16)
    assert joined(constant((1, 1, 1)), wide).terms == 3
    with pytest.raises(ValueError, match="different sizes"):
        joined(wide, factor(SMOOTH, 2, 18))
    with pytest.raises(ValueError, match="parametrisations"):
        joined(wide, factor(SMOOTH, 2, 16, polar=True))


def test_clay_is_the_same_every_time() -> None:
    a, b = factor(CLAY, 4, 24), factor(CLAY, 4, 24)
    np.testing.assert_array_equal(a.light, b.light)
