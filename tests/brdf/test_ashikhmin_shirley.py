"""Ashikhmin-Shirley against the closed forms and limits of its formulas, and its grain."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from brdf.materials import BLACK, direction, hemisphere, model_and_row

from engine.brdf import albedo, evaluate, hemispherical_albedo, pdf, sample
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import GRAIN, from_grain, to_grain
from engine.brdf.published import BRUSHED
from engine.brdf.table import INDEX

WHITE = (1.0, 1.0, 1.0)
ANGLES = (0.0, 30.0, 60.0, 80.0, 88.0)


def turned(row: np.ndarray, degrees: float) -> np.ndarray:
    """The row of a surface whose grain is turned from the local x axis."""
    row = row.copy()
    row[GRAIN:] = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return row


def test_base_reflects_its_closed_form() -> None:
    """R_d (1 - (1 - cos θ / 2)⁵) where there is no interface."""
    material = AshikhminShirley(diffuse=(0.2, 0.5, 1.0), specular=BLACK)
    for angle in ANGLES:
        c = np.cos(np.radians(angle))
        expected = np.array([0.2, 0.5, 1.0]) * (1 - (1 - c / 2) ** 5)
        reflected = albedo(*model_and_row(material), direction(angle))[0]
        np.testing.assert_allclose(reflected, expected, atol=2e-3)


def test_peak_is_that_of_the_paper() -> None:
    """Mirrored at normal incidence: √((n_u + 1)(n_v + 1)) / 8π · R_s, and the base of eq. 5."""
    value = evaluate(*model_and_row(BRUSHED), direction(0), direction(0))[0]
    gloss = np.sqrt(11 * 101) / (8 * np.pi) * 0.75
    base = 28 / (23 * np.pi) * 0.5 * 0.25 * (1 - 0.5**5) ** 2
    np.testing.assert_allclose(value, gloss + base, rtol=1e-6)


def test_against_the_formula_written_out() -> None:
    """Eq. 4 with vectors, term by term, for pairs about each other's mirror image."""
    rng = np.random.default_rng(3)
    wo = hemisphere(rng, 500)
    wi = wo * (-1, -1, 1) + rng.normal(0, 0.3, (500, 3))
    wi = wi / np.linalg.norm(wi, axis=1, keepdims=True)
    wi, wo = wi[wi[:, 2] > 0.01], wo[wi[:, 2] > 0.01]
    nu, nv, rs = 7.0, 300.0, 0.3
    material = AshikhminShirley(diffuse=BLACK, specular=(rs,) * 3, exponent_u=nu, exponent_v=nv)
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    e = (nu * h[:, 0] ** 2 + nv * h[:, 1] ** 2) / (1 - h[:, 2] ** 2)
    hk = np.einsum("ij,ij->i", h, wi)
    expected = np.sqrt((nu + 1) * (nv + 1)) / (8 * np.pi) * h[:, 2] ** e
    expected = expected / (hk * np.maximum(wi[:, 2], wo[:, 2])) * (rs + (1 - rs) * (1 - hk) ** 5)
    np.testing.assert_allclose(
        evaluate(*model_and_row(material), wi, wo)[:, 0], expected, rtol=1e-6, atol=1e-30
    )


def test_sharper_lobes_come_to_reflect_fresnel() -> None:
    """max(n·wi, n·wo) takes from a lobe in proportion to its width: half of it when 4 n."""

    def reflected(exponent: float, angle: float) -> np.ndarray:
        material = AshikhminShirley(
            diffuse=BLACK,
            specular=(0.04, 0.3, 0.9),
            exponent_u=exponent,
            exponent_v=exponent,
        )
        return albedo(*model_and_row(material), direction(angle), points=1 << 16)[0]

    for angle in (0.0, 30.0, 60.0):
        f0 = np.array([0.04, 0.3, 0.9])
        fresnel = f0 + (1 - f0) * (1 - np.cos(np.radians(angle))) ** 5
        wide, narrow = reflected(124.0, angle), reflected(499.0, angle)
        assert (wide <= narrow + 1e-4).all()
        assert (narrow <= fresnel).all()
        np.testing.assert_allclose(2 * narrow - wide, fresnel, rtol=0.02)


@pytest.mark.parametrize("exponents", list(itertools.product((0.0, 1.0, 10.0, 500.0), repeat=2)))
def test_never_reflects_more_than_it_receives(exponents: tuple[float, float]) -> None:
    """So that no scene needs to measure it; white base and white lobe, along and across."""
    for specular in (0.0, 0.02, 0.5, 1.0):
        material = AshikhminShirley(
            diffuse=WHITE,
            specular=(specular,) * 3,
            exponent_u=exponents[0],
            exponent_v=exponents[1],
        )
        wo = np.stack([direction(a, phi) for a in ANGLES for phi in (0.0, 45.0, 90.0)])
        assert albedo(*model_and_row(material), wo).max() <= 1 + 5e-3


def test_grain_turns_the_lobe() -> None:
    """A row with its grain turned is the material seen in a frame turned the other way."""
    rng = np.random.default_rng(4)
    wi, wo = hemisphere(rng, 200), hemisphere(rng, 200)
    model, row = model_and_row(BRUSHED)
    angle = np.radians(25.0)
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    there = evaluate(model, turned(row, 25.0), wi @ turn.T, wo @ turn.T)
    np.testing.assert_allclose(there, evaluate(model, row, wi, wo), rtol=1e-5)
    np.testing.assert_allclose(
        pdf(model, turned(row, 25.0), wi @ turn.T, wo @ turn.T), pdf(model, row, wi, wo), rtol=1e-5
    )
    u = np.column_stack([rng.random((200, 2)), np.full(200, 0.999)])  # the lobe
    there = sample(model, turned(row, 25.0), wo @ turn.T, u)
    np.testing.assert_allclose(there, sample(model, row, wo, u) @ turn.T, atol=1e-6)
    w = (0.3, -0.5, 0.7)
    np.testing.assert_allclose(from_grain(row, to_grain(turned(row, 0), w)), w)
    np.testing.assert_allclose(
        from_grain(turned(row, 130), to_grain(turned(row, 130), w)), w, atol=1e-7
    )


def test_a_quarter_turn_exchanges_the_exponents() -> None:
    rng = np.random.default_rng(5)
    wi, wo = hemisphere(rng, 200), hemisphere(rng, 200)
    other = AshikhminShirley(exponent_u=100.0, exponent_v=10.0)
    model, row = model_and_row(AshikhminShirley(exponent_u=10.0, exponent_v=100.0))
    np.testing.assert_allclose(
        evaluate(model, turned(row, 90.0), wi, wo),
        evaluate(*model_and_row(other), wi, wo),
        rtol=1e-5,
    )


def test_hemispherical_albedo_is_that_of_all_azimuths() -> None:
    """It does not depend on how the grain lies, though the albedo of one direction does."""
    row = AshikhminShirley(diffuse=BLACK, specular=(0.5,) * 3, exponent_u=1, exponent_v=500).row()
    model = INDEX[AshikhminShirley]
    one = [albedo(model, turned(row, a), direction(75, 0))[0, 0] for a in (0.0, 90.0)]
    assert abs(one[0] - one[1]) > 0.015
    mean = [hemispherical_albedo(model, turned(row, a))[0, 0] for a in (0.0, 20.0, 90.0)]
    np.testing.assert_allclose(mean, mean[0], atol=3e-3)
