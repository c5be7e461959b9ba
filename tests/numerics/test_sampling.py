"""Random numbers and warps of the unit square."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit
from numpy.typing import NDArray
from scipy.stats import chi2

from engine.numerics import sampling
from engine.numerics.dispatch import by_index


@njit
def _table(seed, rows, dimensions):
    out = np.zeros((rows, dimensions))
    for i in range(rows):
        for d in range(dimensions):
            out[i, d] = sampling.uniform(seed, i, d)
    return out


def test_uniform_is_a_function_of_its_arguments() -> None:
    """The same on every machine and in every order: these numbers may never change."""
    numbers = [sampling.uniform(*key) for key in ((1, 0, 0), (1, 1, 0), (2, 0, 7))]
    assert numbers == [0.6524484753608704, 0.3681895136833191, 0.254477322101593]


def test_uniform_is_even() -> None:
    """Values, neighbours along both counters, and neighbouring seeds are independent."""
    table = _table(5, 100_000, 4)
    assert table.min() >= 0
    assert table.max() < 1
    pairs = {
        "dimensions": (table[:, 0], table[:, 1]),
        "indices": (table[:-1, 0], table[1:, 0]),
        "seeds": (table[:, 0], _table(6, 100_000, 1)[:, 0]),
    }
    for a, b in pairs.values():
        cells = (16 * a).astype(int) * 16 + (16 * b).astype(int)
        observed = np.bincount(cells, minlength=256)
        expected = len(a) / 256
        statistic = ((observed - expected) ** 2 / expected).sum()
        # Two-sided: numbers that are too even are not independent either.
        assert 1e-3 < chi2.sf(statistic, 255) < 1 - 1e-3


@njit
def _warp(which, u, exponent):
    out = np.zeros((len(u), 3))
    for i in range(len(u)):
        if which == 0:
            d = sampling.cosine_hemisphere(u[i, 0], u[i, 1])
        elif which == 1:
            d = sampling.cosine_power_hemisphere(u[i, 0], u[i, 1], exponent)
        else:
            d = sampling.uniform_sphere(u[i, 0], u[i, 1])
        out[i, 0], out[i, 1], out[i, 2] = d
    return out


def _density(which: int, d: NDArray[np.float64], exponent: float) -> NDArray[np.float64]:
    if which == 0:
        return d[:, 2] / np.pi
    if which == 1:
        return (exponent + 1) / (2 * np.pi) * d[:, 2] ** exponent
    return np.full(len(d), 1 / (4 * np.pi))


@pytest.mark.parametrize(
    ("which", "exponent"), [(0, 1.0), (1, 0.0), (1, 1.0), (1, 30.0), (1, 1e5), (2, 0.0)]
)
def test_jacobian(which: int, exponent: float) -> None:
    """The solid angle into which a small square goes is its area over the density."""
    u = 0.02 + 0.96 * np.random.default_rng(1).random((500, 2))
    h = 1e-6
    sides = [
        (_warp(which, u + h * e, exponent) - _warp(which, u - h * e, exponent)) / (2 * h)
        for e in np.eye(2)
    ]
    area = np.linalg.norm(np.cross(*sides), axis=1)
    d = _warp(which, u, exponent)
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=1e-9)
    np.testing.assert_allclose(area * _density(which, d, exponent), 1, rtol=1e-4)


def test_warps_stand_the_ends_of_the_square() -> None:
    ends = np.array([0.0, 1 - 2.0**-24])
    u = np.stack(np.meshgrid(ends, ends), axis=-1).reshape(-1, 2)
    for which, exponent in ((0, 0.0), (1, 0.0), (1, 1e5), (2, 0.0)):
        d = _warp(which, u, exponent)
        np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=1e-7)
        assert which == 2 or (d[:, 2] >= 0).all()


def test_triangle_is_filled_evenly() -> None:
    """Each of the four similar triangles gets a quarter; the mean is the middle."""
    u = (np.stack(np.mgrid[0:300, 0:300], axis=-1).reshape(-1, 2) + 0.5) / 300
    b = np.array([sampling.uniform_triangle(*row) for row in u])
    assert (b >= 0).all()
    assert (b.sum(axis=1) <= 1).all()
    np.testing.assert_allclose(b.mean(axis=0), 1 / 3, atol=1e-3)
    for quarter in (b[:, 0] > 0.5, b[:, 1] > 0.5, b.sum(axis=1) < 0.5):
        assert quarter.mean() == pytest.approx(0.25, abs=5e-3)


def test_balance() -> None:
    assert sampling.balance(1.0, 3.0) == 0.25
    assert sampling.balance(0.0, 0.0) == 0
    assert sampling.balance(2.0, 1.0) + sampling.balance(1.0, 2.0) == pytest.approx(1)


def test_dispatch_by_index() -> None:
    """Each index calls its own function, inside kernels and outside."""
    choose = by_index([njit(lambda a, b: a + b), njit(lambda a, b: a * b)], 2)

    @njit
    def kernel(i, a, b):
        return choose(i, a, b)

    for call in (choose, kernel):
        assert [call(0, 3.0, 4.0), call(1, 3.0, 4.0), call(2, 3.0, 4.0)] == [7, 12, 12]
    assert by_index([njit(lambda a: -a)], 1)(5, 2.0) == -2


def test_concentric_map_keeps_areas_and_neighbours() -> None:
    """Every cell of a grid becomes a piece of the disk as large as the others, and stays whole."""
    edge = np.linspace(0, 1, 65)
    at = np.array([[sampling.concentric_disk(a, b) for b in edge] for a in edge])
    d1, d2 = at[1:, 1:] - at[:-1, :-1], at[1:, :-1] - at[:-1, 1:]
    area = np.abs(d1[..., 0] * d2[..., 1] - d1[..., 1] * d2[..., 0]) / 2
    assert area.sum() == pytest.approx(np.pi, rel=1e-3)
    # The innermost rings are squares rather than circles, as corners are joined by chords here.
    outer = np.ones((64, 64), bool)
    outer[28:36, 28:36] = False
    np.testing.assert_allclose(area[outer], np.pi / 64**2, rtol=0.01)
    for step in (np.diff(at, axis=0), np.diff(at, axis=1)):
        assert np.linalg.norm(step, axis=2).max() < 1.6 * np.sqrt(np.pi) / 64
    assert np.hypot(at[0, :, 0], at[0, :, 1]) == pytest.approx(1)
    assert sampling.concentric_disk(0.5, 0.5) == (0, 0)


@pytest.mark.parametrize("versine", [1e-9, 0.1, 1.0, 2.0])
def test_uniform_cone(versine: float) -> None:
    """Unit directions within the cone, 1 - cos θ even up to its rim."""
    u = np.random.default_rng(1).random((2000, 2))
    d = np.array([sampling.uniform_cone(a, b, versine) for a, b in u])
    assert np.linalg.norm(d, axis=1) == pytest.approx(1)
    # 1 - cos θ by the sine where the cone is narrow.
    sine2 = d[:, 0] ** 2 + d[:, 1] ** 2
    share = np.where(d[:, 2] > 0, sine2 / (1 + np.abs(d[:, 2])), 1 - d[:, 2]) / versine
    assert 0 <= share.min() < 0.01
    assert 0.99 < share.max() <= 1 + 1e-9
    assert share.mean() == pytest.approx(0.5, abs=0.03)
    assert (share**2).mean() == pytest.approx(1 / 3, abs=0.03)
