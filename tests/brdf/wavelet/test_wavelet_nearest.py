"""Values of the nearest cell: those at its centre, wherever in it the direction lies."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf import evaluate
from engine.brdf.built_in import BUILT_IN
from engine.brdf.measured import LEVEL, NEAREST, Measured
from engine.brdf.table import INDEX
from engine.brdf.wavelet.analysis import Grid
from engine.brdf.wavelet.tabulate import grid_for, incident, outgoing
from engine.errors import InputError
from engine.methods.wavelet_brdf import Settings

MODEL = INDEX[Measured]


def row_of(name: str, *, nearest: bool, level: float = 0.0) -> np.ndarray:
    row = Measured(file=name).row()
    row[NEAREST], row[LEVEL] = nearest, level
    return row


def cells_of_level(grid: Grid, level: int) -> Grid:
    bits = grid.theta_bits - level, grid.phi_bits - level
    return Grid(grid.symmetry, *bits, grid.across, grid.down)


@pytest.mark.parametrize("name", BUILT_IN)
@pytest.mark.parametrize("level", [0, 2])
def test_values_are_those_at_centres(name: str, level: int) -> None:
    measurement = Measured(file=name).measurement()
    grid = cells_of_level(grid_for(measurement), level)
    rng = np.random.default_rng(1)
    wi, wo = incident(grid).reshape(-1, 3), outgoing(grid).reshape(-1, 3)
    i, o = rng.integers(len(wi), size=3000), rng.integers(len(wo), size=3000)
    bilinear = row_of(name, nearest=False, level=level)
    nearest = row_of(name, nearest=True, level=level)
    expected = evaluate(MODEL, bilinear, wi[i], wo[o])
    found = evaluate(MODEL, nearest, wi[i], wo[o])
    np.testing.assert_allclose(found, expected, rtol=2e-4)
    # Anywhere in the cell it is the same number.
    off = rng.uniform(-0.4, 0.4, 2)
    moved = outgoing(grid, *off).reshape(-1, 3)
    np.testing.assert_array_equal(evaluate(MODEL, nearest, wi[i], moved[o]), found)
    assert np.abs(evaluate(MODEL, bilinear, wi[i], moved[o]) / expected - 1).max() > 0.01


def test_settings_know_both_filters() -> None:
    assert Settings().filter == "bilinear"
    with pytest.raises(InputError, match="none of bilinear, nearest"):
        Settings(filter="cubic")
