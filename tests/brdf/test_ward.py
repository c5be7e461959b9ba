"""Ward against its closed forms and the formula written out, its figures, and another renderer."""

from __future__ import annotations

import itertools

import mitsuba
import numpy as np
import pytest
from brdf.materials import BLACK, direction, hemisphere, model_and_row
from scipy.integrate import quad

from engine.brdf import albedo, evaluate, pdf, sample
from engine.brdf.base import GRAIN, ROUGHNESS
from engine.brdf.table import INDEX
from engine.brdf.ward import MIN_ALPHA, Ward

WHITE = (1.0, 1.0, 1.0)
WIDTHS = (0.0, 0.1, 0.2, 0.5, 1.0)


def lobe(along: float, across: float, colour: tuple[float, float, float] = WHITE) -> Ward:
    """The lobe alone."""
    return Ward(diffuse=BLACK, specular=colour, roughness=along, roughness_v=across)


def turned(row: np.ndarray, degrees: float) -> np.ndarray:
    """The row of a surface whose grain is turned from the local x axis."""
    row = row.copy()
    row[GRAIN:] = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return row


def pairs(seed: int, spread: float) -> tuple[np.ndarray, np.ndarray]:
    """Directions at random and about each other's mirror image, down to half a degree above."""
    rng = np.random.default_rng(seed)
    wo, wi = hemisphere(rng, 2000), hemisphere(rng, 2000)
    wi[1000:] = wo[1000:] * (-1, -1, 1) + rng.normal(0, spread, (1000, 3))
    wi /= np.linalg.norm(wi, axis=1, keepdims=True)
    kept = np.minimum(wi[:, 2], wo[:, 2]) > 0.01
    return wi[kept], wo[kept]


@pytest.mark.parametrize(("along", "across"), [(0.1, 0.1), (0.3, 0.06), (0.05, 0.8)])
def test_against_the_formula_written_out(along: float, across: float) -> None:
    """Eq. 5a with the angles δ and φ of the half vector."""
    wi, wo = pairs(3, 0.2)
    h = wi + wo
    delta, phi = np.arctan2(np.hypot(h[:, 0], h[:, 1]), h[:, 2]), np.arctan2(h[:, 1], h[:, 0])
    ax, ay = np.float32(along).astype(float), np.float32(across).astype(float)
    power = -(np.tan(delta) ** 2) * ((np.cos(phi) / ax) ** 2 + (np.sin(phi) / ay) ** 2)
    gloss = np.exp(power) / (4 * np.pi * ax * ay * np.sqrt(wi[:, 2] * wo[:, 2]))
    material = Ward(diffuse=(0.25,) * 3, specular=(0.5,) * 3, roughness=along, roughness_v=across)
    assert (power > -3).sum() > 100
    np.testing.assert_allclose(
        evaluate(*model_and_row(material), wi, wo)[:, 0], 0.25 / np.pi + 0.5 * gloss, rtol=1e-5
    )


def test_peak_from_above() -> None:
    value = evaluate(*model_and_row(Ward()), direction(0), direction(0))[0]
    expected = 0.5 / np.pi + 0.2 / (4 * np.pi * 0.2 * 0.1)
    np.testing.assert_allclose(value, expected, rtol=1e-6)


@pytest.mark.parametrize("alpha", [0.02, 0.2, 0.5, 1.0])
def test_reflects_its_closed_form_from_above(alpha: float) -> None:
    """∫ cos⁴ δ √cos 2δ exp(-t) dt of t = tan² δ / α², until light comes from below."""

    def kept(t: float) -> float:
        z2 = 1 / (1 + alpha * alpha * t)
        return z2 * z2 * np.sqrt(max(0.0, 2 * z2 - 1)) * np.exp(-t)

    expected = quad(kept, 0, min(1 / alpha**2, 60.0))[0]
    reflected = albedo(*model_and_row(lobe(alpha, alpha)), direction(0), points=1 << 16)[0, 0]
    assert reflected == pytest.approx(expected, abs=5e-4)


def test_figures_of_the_docstring() -> None:
    """The sharpest reflects cos θ; none more than ρ_s up to 89.4 degrees, and some do at 89.9."""
    for angle in (0.0, 40.0, 70.0, 85.0):
        reflected = albedo(*model_and_row(lobe(0, 0)), direction(angle))[0, 0]
        assert reflected == pytest.approx(np.cos(np.radians(angle)), abs=2e-3)
    for alpha, said in ((0.2, 0.90), (0.5, 0.59), (1.0, 0.26)):
        above = albedo(*model_and_row(lobe(alpha, alpha)), direction(0))[0, 0]
        assert above == pytest.approx(said, abs=6e-3)
    wo = np.stack(
        [direction(a, phi) for a in (0, 30, 60, 80, 85, 88, 89, 89.4) for phi in (0, 45, 90)]
    )
    most = max(
        albedo(*model_and_row(lobe(*widths)), wo, points=1 << 14).max()
        for widths in itertools.product(WIDTHS, repeat=2)
    )
    assert most <= 1
    worst, low = lobe(1, MIN_ALPHA), direction(89.9, 0)
    below = albedo(*model_and_row(worst), direction(89.4, 0), points=1 << 16)[0, 0]
    assert below == pytest.approx(0.98, abs=5e-3)
    reflected = albedo(*model_and_row(worst), low, points=1 << 16)[0, 0]
    assert reflected == pytest.approx(2.35, abs=0.01)
    assert reflected * np.sqrt(low[2]) == pytest.approx(0.098, abs=1e-3)
    round_one = albedo(*model_and_row(lobe(0.3, 0.3)), low, points=1 << 16)[0, 0]
    assert round_one == pytest.approx(1.05, abs=0.01)


def test_a_round_lobe_does_not_know_the_grain() -> None:
    wi, wo = pairs(4, 0.3)
    model, row = model_and_row(lobe(0.25, 0.25))
    value, density = evaluate(model, row, wi, wo), pdf(model, row, wi, wo)
    for angle in (17.0, 90.0, 200.0):
        there = turned(row, angle)
        np.testing.assert_allclose(evaluate(model, there, wi, wo), value, rtol=1e-5, atol=1e-12)
        np.testing.assert_allclose(pdf(model, there, wi, wo), density, rtol=1e-5, atol=1e-12)


def test_grain_turns_the_lobe() -> None:
    """A row with its grain turned is the material seen in a frame turned the other way."""
    wi, wo = pairs(5, 0.3)
    model, row = model_and_row(Ward())
    c, s = np.cos(np.radians(25.0)), np.sin(np.radians(25.0))
    turn = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]])
    there = evaluate(model, turned(row, 25.0), wi @ turn.T, wo @ turn.T)
    np.testing.assert_allclose(there, evaluate(model, row, wi, wo), rtol=1e-4)
    u = np.random.default_rng(6).random((len(wo), 3))
    u[:, 2] = 0.999  # the lobe
    there = sample(model, turned(row, 25.0), wo @ turn.T, u)
    np.testing.assert_allclose(there, sample(model, row, wo, u) @ turn.T, atol=1e-6)
    across = Ward(roughness=0.1, roughness_v=0.2)
    np.testing.assert_allclose(
        evaluate(model, turned(row, 90.0), wi, wo),
        evaluate(*model_and_row(across), wi, wo),
        rtol=1e-4,
    )


def test_a_texture_of_roughness_multiplies_both_widths() -> None:
    """Which only knows the place that all rows share."""
    row = Ward(roughness=0.4, roughness_v=0.1).row()
    row[ROUGHNESS] *= 0.5
    np.testing.assert_allclose(row, Ward(roughness=0.2, roughness_v=0.05).row(), rtol=1e-6)


def test_samples_have_the_density_of_the_slopes() -> None:
    """Of slopes stretched to a round lobe, exp(-r²) are longer than r, evenly all round."""
    u = np.random.default_rng(7).random((2000, 3))
    h = sample(*model_and_row(lobe(0.4, 0.05)), direction(0), u) + direction(0)
    slope = h[:, :2] / h[:, 2:] / np.float32([0.4, 0.05])
    np.testing.assert_allclose(np.exp(-(slope**2).sum(axis=1)), 1 - u[:, 0], rtol=1e-5, atol=1e-9)
    turn = np.arctan2(slope[:, 1], slope[:, 0]) / (2 * np.pi) % 1
    np.testing.assert_allclose(turn, u[:, 1], atol=1e-5)


def test_density_against_mitsuba() -> None:
    """Beckmann's slopes are the same: only what they reflect is another formula."""
    mitsuba.set_variant("scalar_rgb")
    theirs = mitsuba.load_dict(
        {
            "type": "roughconductor",
            "distribution": "beckmann",
            "alpha_u": 0.4,
            "alpha_v": 0.1,
            "material": "none",
            "sample_visible": False,
        }
    )
    context, seen = mitsuba.BSDFContext(), mitsuba.SurfaceInteraction3f()
    row, rng = lobe(0.4, 0.1).row(), np.random.default_rng(8)
    for angle in (0.0, 30.0, 65.0):
        wo = direction(angle)
        wi = sample(INDEX[Ward], row, wo, rng.random((200, 3)))
        wi = wi[wi[:, 2] > 1e-3]
        seen.wi = mitsuba.Vector3f(*wo)
        density = [theirs.pdf(context, seen, mitsuba.Vector3f(*w)) for w in wi]
        np.testing.assert_allclose(pdf(INDEX[Ward], row, wi, wo), density, rtol=2e-3)
