"""Means and log-ratios: exact, linear in the light, and no energy lost at any level."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.wavelet import layout
from engine.brdf.wavelet.analysis import Grid, analyse, synthesise
from engine.brdf.wavelet.layout import schedule
from engine.brdf.wavelet.tabulate import outgoing

GRIDS = [
    Grid(layout.GENERAL, 3, 3, 2, 2),
    Grid(layout.ORTHOTROPIC, 2, 2, 2, 2),
    Grid(layout.ISOTROPIC, 4, 3, 3, 1),
    Grid(layout.ISOTROPIC, 2, 4, 3, 1),
    Grid(layout.GENERAL, 1, 0, 1, 1),
]
every_grid = pytest.mark.parametrize("grid", GRIDS, ids=str)


def values_of(grid: Grid, seed: int = 1) -> np.ndarray:
    rng = np.random.default_rng(seed)
    return np.exp(3 * rng.normal(size=(*grid.cells, grid.down, grid.across, 3)))


@every_grid
def test_inverse(grid: Grid) -> None:
    values = values_of(grid)
    mean, ratios, _ = analyse(values, grid)
    assert len(ratios) == 2 ** (grid.theta_bits + grid.phi_bits) - 1
    np.testing.assert_allclose(synthesise(mean, ratios, grid), values, rtol=1e-10)


@every_grid
def test_light_twice_as_bright_changes_the_mean_alone(grid: Grid) -> None:
    values = values_of(grid)
    (mean, ratios, parts), (twice, same, also) = analyse(values, grid), analyse(2 * values, grid)
    np.testing.assert_allclose(also, parts)
    np.testing.assert_allclose(twice, 2 * mean)
    np.testing.assert_allclose(same, ratios, atol=1e-12)


@every_grid
def test_an_even_brdf_has_no_coefficients(grid: Grid) -> None:
    mean, ratios, _ = analyse(np.full_like(values_of(grid), 0.7), grid)
    np.testing.assert_allclose(mean, 0.7)
    np.testing.assert_allclose(ratios, 0, atol=1e-13)


@every_grid
def test_every_level_reflects_the_same(grid: Grid) -> None:
    """∫ f cos θ over the outgoing directions, from the values of any level, left-out ones too."""
    values = values_of(grid)
    weight = np.multiply.outer(*grid.weights)
    expected = np.einsum("ij,ij...->...", weight, values)
    mean, ratios, _ = analyse(values, grid)
    ratios[np.random.default_rng(2).random(len(ratios)) < 0.3] = 0
    for depth in range(grid.theta_bits + grid.phi_bits + 1):
        coarse = synthesise(mean, ratios, grid, depth)
        area = weight.reshape(
            coarse.shape[0], -1, coarse.shape[1], weight.shape[1] // coarse.shape[1]
        )
        reflected = np.einsum("ij,ij...->...", area.sum(axis=(1, 3)), coarse)
        np.testing.assert_allclose(reflected, expected, rtol=1e-12)


@pytest.mark.parametrize("grid", GRIDS[:4], ids=str)
def test_weights_are_projected_solid_angles(grid: Grid) -> None:
    """Against a fine sum over each cell."""
    fine, found = 24, np.zeros(grid.cells)
    offsets = (np.arange(fine) + 0.5) / fine - 0.5
    for dx in offsets:
        for dy in offsets:
            w = outgoing(grid, dx, dy)
            found += w[..., 2] * np.sqrt(1 - w[..., 1] ** 2)
    np.testing.assert_allclose(found / found.sum(), np.multiply.outer(*grid.weights), rtol=2e-3)


def test_splits_go_in_turns() -> None:
    """Longitude first from the leaves; what one angle has more is split nearest to the root."""
    splits, depths = schedule(3, 2)
    assert splits.tolist() == [[0, 2, 2], [1, 2, 1], [0, 1, 1], [1, 1, 0], [0, 0, 0]]
    assert depths.tolist() == [[4, 3], [2, 1], [0, 0]]
