"""Rows in wavelet space: the sparse, packed ones equal the dense, obvious ones."""

from __future__ import annotations

import numpy as np
import pytest
from methods.fixed_view.gather_matrix import (
    Cloud,
    cloud,
    dense_rows,
    haar_rows,
    links_of,
    packed,
    projected,
    unpacked,
)

N = 1024


def corner() -> Cloud:
    """Samples at random on a floor and a wall that meet."""
    rng = np.random.default_rng(3)
    u, v = rng.uniform(0, 1, (2, N))
    wall = np.arange(N) % 2 == 0
    position = np.where(
        wall[:, None], np.column_stack([u, v, 0 * u]), np.column_stack([u, 0 * u, v])
    )
    normal = np.where(wall[:, None], [[0.0, 0, 1]], [[0.0, 1, 0]])
    return cloud(position, normal, 2 / N)


@pytest.fixture(scope="module")
def tile():
    """64 points above the corner: (samples, room, blocked)."""
    samples = corner()
    rng = np.random.default_rng(4)
    points = rng.uniform(0.2, 0.9, (64, 3))
    normals = np.tile([0, -(0.5**0.5), -(0.5**0.5)], (64, 1))
    room, count = links_of(points, normals, samples)
    blocked = rng.random(count) < 0.4
    return samples, room, blocked


def dense_of(ids, values, starts, n: int = N) -> np.ndarray:
    out = np.zeros((len(starts) - 1, n))
    for b in range(len(out)):
        run = slice(starts[b], starts[b + 1])
        assert len(np.unique(ids[run])) == starts[b + 1] - starts[b], "a wavelet comes twice"
        out[b, ids[run]] = values[run]
    return out


def test_project_is_the_haar_transform_of_the_row(tile):
    samples, room, blocked = tile
    expected = haar_rows(dense_rows(room, blocked, samples))
    found = dense_of(*projected(room, blocked, samples))
    np.testing.assert_allclose(found, expected, atol=1e-6 * np.abs(expected).max())
    assert np.abs(found).max() > 0.01


def test_a_point_that_sees_nothing_has_an_empty_row(tile):
    samples, room, blocked = tile
    ids, values, starts = projected(room, np.ones_like(blocked), samples)
    assert len(ids) == len(values) == 0
    assert not starts.any()


def test_packing_everything_reproduces_the_rows(tile):
    """To half a step, the 254th part of the greatest coefficient of each wavelet."""
    samples, room, blocked = tile
    ids, values, starts = projected(room, blocked, samples)
    rows, kept = packed(ids, values, starts, N, N)
    assert kept == pytest.approx(1)
    assert rows.steps.min() >= -127
    assert len(np.unique(rows.ids)) == len(rows.ids)
    exact = dense_of(ids, values, starts)
    step = np.abs(exact).max(axis=0) / 127
    assert (np.abs(unpacked(rows, N) - exact) <= 0.501 * step + 1e-9).all()


def test_lists_hold_what_own_lists_would(tile):
    """At least the energy that rows keep with k coefficients each, and not much more room."""
    samples, room, blocked = tile
    ids, values, starts = projected(room, blocked, samples)
    exact = dense_of(ids, values, starts)
    energy = (exact**2).sum()
    last = 0.0
    for k in (1, 4, 16, 64, 256):
        rows, kept = packed(ids, values, starts, N, k)
        own = np.sort(exact**2, axis=1)[:, -k:].sum() / energy
        shown = (exact[:, rows.ids] ** 2).sum() / energy
        assert kept == pytest.approx(shown, rel=1e-4)
        if len(rows.ids) < 8 * k:
            assert kept >= own * (1 - 1e-6)
            # One wavelet fewer would keep less than that.
            without = (exact[:, rows.ids[:-1]] ** 2).sum() / energy
            assert without < own
        assert k <= len(rows.ids) <= 8 * k
        assert kept > last
        last = kept


def test_the_greatest_energy_comes_first(tile):
    samples, room, blocked = tile
    ids, values, starts = projected(room, blocked, samples)
    energy = (dense_of(ids, values, starts) ** 2).sum(axis=0)
    rows, _ = packed(ids, values, starts, N, 16)
    k = len(rows.ids)
    np.testing.assert_array_equal(np.sort(rows.ids), np.sort(np.argsort(-energy)[:k]))


def test_importance_steers_the_choice(tile):
    samples, room, blocked = tile
    ids, values, starts = projected(room, blocked, samples)
    importance = np.full(N, 1e-6, np.float32)
    wanted = np.unique(ids)[::7]
    importance[wanted] = 1
    rows, _ = packed(ids, values, starts, N, 4, importance)
    assert np.isin(rows.ids, wanted).all()


def test_one_huge_and_many_tiny_coefficients():
    """Every wavelet has a scale of its own, so a huge one cannot drown the tiny ones."""
    ids = np.arange(N, dtype=np.int32)
    values = np.full(N, 1e-6, np.float32)
    values[17] = 1e6
    starts = np.full(65, N, np.int64)
    starts[0] = 0
    # A share of one wavelet is all that counts in energy, but with room for all none is lost.
    rows, kept = packed(ids, values, starts, N, N)
    found = unpacked(rows, N)[0]
    assert kept == pytest.approx(1)
    stored = rows.ids
    np.testing.assert_allclose(found[stored], values[stored], rtol=1e-6)
    dropped = np.setdiff1d(ids, stored)
    assert 17 in stored
    assert np.abs(values[dropped]).sum() <= 1e-6 * N


def test_huge_beside_tiny_within_one_wavelet():
    """What rounding loses in a small row is at most half a step of the largest."""
    starts = np.arange(65, dtype=np.int64)
    values = np.float32(10.0) ** -np.arange(64, dtype=np.float32)
    rows, _ = packed(np.zeros(64, np.int32), values, starts, N, 8)
    found = unpacked(rows, N)[:, 0]
    assert np.abs(found - values).max() <= 0.5 / 127 * (1 + 1e-5)
    assert found[0] == pytest.approx(1)


def test_rows_of_nothing():
    rows, kept = packed(
        np.zeros(0, np.int32), np.zeros(0, np.float32), np.zeros(65, np.int64), N, 100
    )
    assert rows.length.tolist() == [0]
    assert kept == 1
