"""Samplers against their densities."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.grid import about_mirror, counts
from brdf.materials import EXTREMES, LOBES, direction, model_and_row, name_of
from scipy.stats import chi2

from engine.brdf import Material, albedo, evaluate, pdf, sample
from engine.brdf.measured import Measured

ANGLES = (0.0, 40.0, 80.0)
TESTS = len(EXTREMES) * len(ANGLES)
SAMPLES = 100_000
# Samples of a code fall off from the centre of one cell to those of the next, and so do those of
# the next: the area of one of these tents is not that of all. The chi-square test has them all.
OF_ONE_MAP = [m for m in LOBES if not isinstance(m, Measured)]


@pytest.mark.parametrize("material", OF_ONE_MAP, ids=name_of)
@pytest.mark.parametrize("angle", [5.0, 40.0, 75.0])
def test_jacobian(material: Material, angle: float) -> None:
    """The area into which `sample` maps a small square of (u1, u2) is its area / pdf."""
    model, row = model_and_row(material)
    wo = direction(angle)
    rng = np.random.default_rng(3)
    u = np.column_stack([0.05 + 0.9 * rng.random((400, 2)), rng.random(400)])
    step = 1e-5
    sides = []
    for axis in range(2):
        shift = step * np.eye(3)[axis]
        sides.append(
            (sample(model, row, wo, u + shift) - sample(model, row, wo, u - shift)) / (2 * step)
        )
    area = np.linalg.norm(np.cross(*sides), axis=1)
    wi = sample(model, row, wo, u)
    kept = wi[:, 2] > 1e-3
    assert kept.sum() > 100
    np.testing.assert_allclose(area[kept] * pdf(model, row, wi[kept], wo), 1, rtol=1e-4)


@pytest.mark.parametrize("material", EXTREMES, ids=name_of)
@pytest.mark.parametrize("angle", ANGLES)
def test_chi_square(material: Material, angle: float) -> None:
    """Samples fall into cells as often as the density says, the light that is lost included."""
    model, row = model_and_row(material)
    wo = direction(angle)
    rng = np.random.default_rng(4)
    wi = sample(model, row, wo, rng.random((SAMPLES, 3)))
    grid = about_mirror(wo)
    density = pdf(model, row, grid.directions.reshape(-1, 3), wo)
    expected = (density.reshape(grid.weights.shape) * grid.weights).sum(axis=2) * SAMPLES
    kept = wi[wi[:, 2] > 0]
    observed = counts(grid, kept)
    # The density integrates to what is not lost.
    lost = 1 - len(kept) / SAMPLES
    noise = 5 * np.sqrt(max(lost, 1 / SAMPLES) / SAMPLES)
    assert expected.sum() / SAMPLES + lost == pytest.approx(1, abs=noise + 2e-3)
    # Lost light is a cell of its own; cells that expect few samples are pooled. Where nothing is
    # lost, what the grid makes of a density that ends at the horizon may be a little above 1.
    e = np.append(expected.ravel(), max(0.0, SAMPLES - expected.sum()))
    o = np.append(observed.ravel(), SAMPLES - len(kept))
    order = np.argsort(e)
    e, o = e[order], o[order]
    few = np.searchsorted(np.cumsum(np.maximum(e, 0)), 5.0) + 1
    e, o = np.append(e[:few].sum(), e[few:]), np.append(o[:few].sum(), o[few:])
    assert len(e) > 10
    statistic = ((o - e) ** 2 / np.maximum(e, 1e-9)).sum()
    # Šidák: the chance of any false alarm among all these tests is one in a hundred.
    threshold = 1 - (1 - 0.01) ** (1 / TESTS)
    assert chi2.sf(statistic, len(e) - 1) > threshold, f"{statistic:.0f} over {len(e)} cells"


@pytest.mark.parametrize("material", EXTREMES, ids=name_of)
@pytest.mark.parametrize("angle", ANGLES)
def test_albedo_is_the_integral_of_the_value(material: Material, angle: float) -> None:
    """What the sampler adds up to is what a grid that knows nothing of it adds up to."""
    model, row = model_and_row(material)
    wo = direction(angle)
    grid = about_mirror(wo)
    wi = grid.directions.reshape(-1, 3)
    weight = grid.weights.ravel() * np.maximum(wi[:, 2], 0)
    expected = (evaluate(model, row, wi, wo) * weight[:, None]).sum(axis=0)
    np.testing.assert_allclose(albedo(model, row, wo)[0], expected, atol=5e-3)
