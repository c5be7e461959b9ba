"""Errors of a code are what they say."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.wavelet import layout
from engine.brdf.wavelet.analysis import Grid
from engine.brdf.wavelet.errors import errors_of, floors

GRID = Grid(layout.GENERAL, 2, 2, 4, 4)


@pytest.fixture
def values() -> np.ndarray:
    return np.random.default_rng(3).uniform(0.1, 2, (4, 4, 4, 4, 3))


def test_nothing_is_off(values: np.ndarray) -> None:
    assert not any(errors_of(values, values, GRID, floors(values, 1e-3)).as_dict().values())


def test_all_is_missing(values: np.ndarray) -> None:
    dark = errors_of(0 * values, values, GRID, np.zeros(3))
    assert dark.mean == pytest.approx(1)
    assert dark.light == pytest.approx(0.5)  # half of what is missing and of what is too much
    assert dark.rms == pytest.approx(float(np.sqrt((values**2).mean())))


def test_one_in_48_is_off(values: np.ndarray) -> None:
    found = values.copy()
    found.reshape(-1)[::48] *= 1.5
    errors = errors_of(found, values, GRID, np.zeros(3))
    assert errors.mean == pytest.approx(0.5 / 48)
    assert errors.p99 == pytest.approx(0.5)


def test_a_black_channel_has_the_floor_of_all(values: np.ndarray) -> None:
    values[..., 1] = 0
    red, green, blue = floors(values, 0.01)
    assert red == pytest.approx(0.01 * values[..., 0].mean())
    assert green == pytest.approx((red + blue) / 3)
    assert floors(0 * values, 0.01).tolist() == [0.01] * 3
