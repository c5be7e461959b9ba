"""What a tile keeps of its wavelets, against the dense rows that it stands for."""

from __future__ import annotations

import numpy as np
import pytest
from methods.fixed_view.gather_matrix import packed, scales_of, steps_of, unpacked

from engine.methods.fixed_view.packing import PRICE
from engine.numerics.haar import forward
from engine.numerics.packed import TILE, step_units

N = 256


def sparse(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(ids, values, starts) of dense rows (64, N), as `rows.project` gives them."""
    row, ids = np.nonzero(rows)
    starts = np.searchsorted(row, np.arange(TILE + 1))
    return ids.astype(np.int32), rows[row, ids].astype(np.float32), starts.astype(np.int64)


def noisy_rows(noise: float, seed: int = 1) -> np.ndarray:
    """(64, N): every wavelet has a slope over the tile, and noise, of very different height."""
    rng = np.random.default_rng(seed)
    y, x = np.divmod(np.arange(TILE), 8)
    height = rng.lognormal(0, 2, N)
    slope = rng.normal(size=(2, N))
    smooth = 1 + 0.1 * (np.outer(x / 8, slope[0]) + np.outer(y / 8, slope[1]))
    return height * (smooth + noise * rng.lognormal(0, 1.5, N) * rng.normal(size=(TILE, N)))


def energy_of(rows: np.ndarray) -> float:
    return float((rows.astype(float) ** 2).sum())


def test_packing_everything_reproduces_the_rows() -> None:
    """A row is the mean and nine numbers, three of each level, each right to half a step."""
    rows = noisy_rows(1.0)
    found, kept = packed(*sparse(rows), N, N)
    assert kept == pytest.approx(1)
    assert np.abs(found.steps.astype(int)).max() == 127
    assert len(np.unique(found.ids)) == len(found.ids) == N
    step = np.zeros(N)
    step[found.ids] = scales_of(found)
    error = unpacked(found, N) - rows
    assert (np.abs(error) <= 4.51 * step + 1e-9).all()
    assert np.sqrt(np.mean((error / step) ** 2)) < 1.1 * np.sqrt(9 / 12)
    np.testing.assert_allclose(found.mean, rows.mean(axis=0)[found.ids], rtol=1e-4, atol=1e-6)


def test_more_coefficients_keep_more() -> None:
    rows = noisy_rows(0.1)
    energy, last = energy_of(rows), 0.0
    for k in (1, 4, 16, 64, 256):
        found, kept = packed(*sparse(rows), N, k)
        # What is lost is the rest, but for the rounding to eight bits.
        lost = energy_of(unpacked(found, N) - rows) / energy
        assert lost == pytest.approx(1 - kept, abs=3e-4)
        assert kept > last
        last = kept
    assert last == pytest.approx(1)


def test_the_coarse_steps_of_a_wavelet_come_first() -> None:
    """Whatever is kept is the best that so many steps can say: the coefficients over the tile."""
    rows = noisy_rows(0.1)
    found, _ = packed(*sparse(rows), N, 32)
    every = steps_of(found)
    assert len({len(steps) for steps in every}) >= 3
    assert (np.diff([len(steps) for steps in every]) <= 0).all()
    over_tile = forward(np.ascontiguousarray(rows, np.float32)) / step_units()[:, None]
    for k, (steps, scale) in enumerate(zip(every, scales_of(found), strict=True)):
        exact = over_tile[1 : len(steps), found.ids[k]]
        assert (np.abs(steps[1:] * scale - exact) <= 0.51 * scale).all()


def test_rows_that_are_all_alike_take_no_steps() -> None:
    rows = np.tile(noisy_rows(0.0)[:1], (TILE, 1))
    found, kept = packed(*sparse(rows), N, 16)
    assert len(found.steps) == 0
    price = PRICE * np.sort(rows[0] ** 2)[-16]
    worth = TILE * rows[0] ** 2 > 8 * price
    assert len(found.ids) == worth.sum() >= 16
    assert kept == pytest.approx((rows[0] ** 2)[worth].sum() / (rows[0] ** 2).sum(), rel=1e-3)


def test_smooth_rows_take_far_less_than_noise() -> None:
    smooth, rough = (packed(*sparse(noisy_rows(noise)), N, 16)[0] for noise in (0.02, 3.0))
    assert len(smooth.steps) < 0.25 * len(rough.steps)


def test_bytes_are_spent_where_they_buy_most() -> None:
    """At the price that the last coefficient of a row sets, every wavelet has its best width."""
    rows = noisy_rows(0.1)
    found, _ = packed(*sparse(rows), N, 32)
    price = PRICE * np.sort(rows**2, axis=1)[:, -32].mean()
    over_tile = forward(np.ascontiguousarray(rows, np.float32)).astype(float) ** 2
    held = np.array([np.zeros(N), *(over_tile[:width].sum(axis=0) for width in (1, 4, 16, 64))])
    best = (held - price * np.array([[0], [8], [16], [28], [76]])).argmax(axis=0)
    width = np.zeros(N, int)
    width[found.ids] = [max(1, len(steps)) for steps in steps_of(found)]
    np.testing.assert_array_equal(width, np.array([0, 1, 4, 16, 64])[best])
    assert len(set(width)) == 5


def test_importance_steers_the_choice() -> None:
    rows = noisy_rows(0.3)
    importance = np.full(N, 1e-6, np.float32)
    wanted = np.arange(N)[::7]
    importance[wanted] = 1
    found, _ = packed(*sparse(rows), N, 4, importance)
    assert len(found.ids)
    assert np.isin(found.ids, wanted).all()


def test_rows_that_nobody_wants_cost_nothing() -> None:
    """Past the picture's edge a tile goes on as it is inside."""
    rows = np.tile(noisy_rows(0.0)[:1], (TILE, 1))
    wanted = np.ones(TILE, np.bool_)
    wanted[13:] = False
    rows[~wanted] = 0
    found, _ = packed(*sparse(rows), N, 16, wanted=wanted)
    assert len(found.steps) == 0
    np.testing.assert_allclose(unpacked(found, N)[0, found.ids], rows[0, found.ids], rtol=1e-5)
    # A point that sees nothing is another thing: it stays black.
    black, _ = packed(*sparse(rows), N, N)
    assert len(black.steps) > 0
    assert (np.abs(unpacked(black, N)[~wanted]) <= 4.51 * np.abs(rows).max(axis=0) / 127).all()


def test_one_huge_and_many_tiny_coefficients() -> None:
    """Every wavelet has a scale of its own, so a huge one cannot drown the tiny ones."""
    rows = np.full((TILE, N), 1e-6)
    rows[:, 17] = 1e6
    found, kept = packed(*sparse(rows), N, N)
    assert kept == pytest.approx(1)
    stored = found.ids
    np.testing.assert_allclose(unpacked(found, N)[:, stored], rows[:, stored], rtol=1e-6)
    assert 17 in stored


def test_huge_beside_tiny_within_one_wavelet() -> None:
    """What rounding loses in a small row is at most 4.5 steps, each the 254th of the largest."""
    starts = np.arange(TILE + 1, dtype=np.int64)
    values = np.float32(10.0) ** -np.arange(TILE, dtype=np.float32)
    found, _ = packed(np.zeros(TILE, np.int32), values, starts, N, 8)
    back = unpacked(found, N)[:, 0]
    assert np.abs(back - values).max() <= 4.5 * found.scale[0]
    assert found.scale[0] <= 0.51 / 127
    assert back[0] == pytest.approx(1, rel=1e-2)


def test_rows_of_nothing() -> None:
    nothing = np.zeros(0, np.int32), np.zeros(0, np.float32), np.zeros(TILE + 1, np.int64)
    found, kept = packed(*nothing, N, 100)
    assert found.length.tolist() == [[0, 0, 0, 0]]
    assert kept == 1
