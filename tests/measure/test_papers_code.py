"""The paper's encoding, as a baseline: an orthonormal transform, slices left out by their norm."""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.wavelet import layout
from engine.brdf.wavelet.analysis import Grid
from engine.brdf.wavelet.errors import errors_of, floors
from engine.brdf.wavelet.tabulate import tabulate
from engine.measure.code_study import models
from engine.measure.papers_code import PapersCode, backward, forward

FLOOR = 1e-3
GRID = Grid(layout.GENERAL, 3, 3, 8, 8)
SLICE = 8 * 8 * 3


@pytest.fixture(scope="module")
def values() -> np.ndarray:
    return tabulate(models()["ward"]["α = 0.5, 0.2"], GRID, within=1)


def test_transform_is_orthonormal() -> None:
    rng = np.random.default_rng(1)
    x = rng.normal(size=(16, 16, 2))
    y = forward(x)
    np.testing.assert_allclose(backward(y), x, atol=1e-12)
    assert (y**2).sum() == pytest.approx((x**2).sum())
    assert y[0, 0] == pytest.approx(x.sum(axis=(0, 1)) / 16)


def test_all_slices_are_all_there_is(values: np.ndarray) -> None:
    code = PapersCode(values, FLOOR)
    np.testing.assert_allclose(code.at(64, octets=False), values, rtol=1e-5)
    octets = errors_of(code.at(64, octets=True), values, GRID, floors(values, FLOOR))
    assert 0 < octets.mean < 0.02


def test_bytes_are_those_of_slices_and_map(values: np.ndarray) -> None:
    code = PapersCode(values, FLOOR)
    assert code.bytes_of(5, octets=True) == 5 * SLICE + 2 * 64
    assert code.bytes_of(5, octets=False) == 5 * SLICE * 4 + 2 * 64
    for size in (300, 1000, 5000, 10**6):
        kept = code.kept(size, octets=True)
        assert kept == 64 or code.bytes_of(kept + 1, octets=True) > size
        assert kept == 0 or code.bytes_of(kept, octets=True) <= size
    assert code.kept(100, octets=True) == 0


def test_the_least_norm_goes_first(values: np.ndarray) -> None:
    """What is left out of the logarithm is what its norms say; the mean slice always stays."""
    code = PapersCode(values, FLOOR)
    mean = values.mean(dtype=np.float64)
    right = np.log(values / mean + FLOOR)
    off = []
    for kept in (1, 4, 16, 63):
        found = np.log(code.at(kept, octets=False) / mean + FLOOR)
        off.append(float(((found - right) ** 2).sum()))
    assert off == sorted(off, reverse=True)
    slices = np.sort((forward(right.astype(float)) ** 2).sum(axis=(2, 3, 4)).ravel())
    assert off[-1] == pytest.approx(slices[0], rel=1e-3)
