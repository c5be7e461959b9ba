"""The chance that is reckoned for wavelets, against what rows of the same point differ by."""

from __future__ import annotations

import numpy as np
import pytest

from engine.light.environment_samples import DEPTH
from engine.methods.fixed_view.gather import cosine_lobes
from engine.methods.fixed_view.gather_rays import aim, escape
from engine.methods.fixed_view.hierarchy import level_start
from engine.methods.fixed_view.ray_noise import (
    cluster_of,
    forget_noise,
    make_landed,
    ray_noise,
)
from engine.methods.fixed_view.rows import Rows, make_scratch, project
from engine.numerics.haar import forward
from engine.numerics.packed import TILE

SMALL = 3  # levels of a tree of 64 samples


def reckoned(rows: Rows, depth: int, count: int = TILE, chance: float = 1.0) -> np.ndarray:
    """(4^depth,) float64: noise of every wavelet, 0 where no ray lands."""
    landed = make_landed(4**depth)
    ray_noise(*rows, count, chance, depth, landed)
    found = landed.variance[[cluster_of(k) for k in range(4**depth)]]
    forget_noise(rows.cluster, rows.first[-1], landed)
    for array in landed:
        assert not array.any()
    return found


def coefficients(rows: Rows, depth: int) -> np.ndarray:
    """(64, 4^depth): the rows in wavelet space."""
    ids, values = np.zeros(1 << 20, np.int32), np.zeros(1 << 20, np.float32)
    starts = np.zeros(TILE + 1, np.int64)
    count = project(*rows, depth, make_scratch(4**depth), ids, values, starts)
    out = np.zeros((TILE, 4**depth))
    out[np.repeat(np.arange(TILE), np.diff(starts)), ids[:count]] = values[:count]
    return out


def under_open_sky(count: int) -> Rows:
    """Rows of 64 matt points at one place, by rays of a lattice that meet nothing."""
    up = np.tile(np.float32([0.3, 0.9, 0.1]) / np.sqrt(0.91), (TILE, 1)).astype(np.float32)
    most = TILE * count
    origin, direction = np.zeros((2, most, 3), np.float32)
    weight, escaped = np.zeros((2, most), np.float32)
    first, cell = np.zeros(TILE + 1, np.int32), np.zeros(most, np.int32)
    rays = aim(
        np.arange(TILE), np.zeros_like(up), up, up, *cosine_lobes(up), 1e-4, 1, count, origin,
        direction, first, weight, np.zeros(TILE),
    )  # fmt: skip
    free = np.ones(rays, np.bool_)
    escape(free, direction[:rays], weight, DEPTH, cell, escaped)
    return Rows(first, cell[:rays], escaped[:rays])


def test_one_ray_is_all_chance() -> None:
    """A ray in one row of 64: its weight squared times the wavelet's height squared, by 64."""
    leaf = 37
    rows = Rows(np.int32([0, *[1] * TILE]), np.int32([21 + leaf]), np.float32([2.0]))
    one = np.zeros((64, 1), np.float32)
    one[leaf] = 2.0
    expected = forward(one)[:, 0] ** 2 / TILE
    np.testing.assert_allclose(reckoned(rows, SMALL), expected, rtol=1e-6)
    np.testing.assert_allclose(reckoned(rows, SMALL, chance=0.5), expected / 2, rtol=1e-6)


def test_a_cluster_counts_as_one_ray_and_has_no_details() -> None:
    """Its weight is what each of its samples gets."""
    cluster = level_start(1) + 2
    rows = Rows(np.int32([0, *[1] * TILE]), np.int32([cluster]), np.float32([0.5]))
    found = reckoned(rows, SMALL, count=1)
    assert found[0] == pytest.approx((0.5 * 16) ** 2 / 64)
    np.testing.assert_allclose(found[1:4], found[0], rtol=1e-6)
    assert not found[4:].any()


def test_independent_rays_differ_by_what_is_reckoned() -> None:
    """One of each row, that lands anywhere."""
    rng = np.random.default_rng(5)
    sets = 400
    first = np.arange(TILE + 1, dtype=np.int32)
    variance, noise = np.zeros((2, 64))
    for _ in range(sets):
        cluster = (21 + rng.integers(0, 64, TILE)).astype(np.int32)
        rows = Rows(first, cluster, rng.uniform(0.5, 1.5, TILE).astype(np.float32))
        variance += coefficients(rows, SMALL).var(axis=0) / sets
        noise += reckoned(rows, SMALL) / sets
    np.testing.assert_allclose(variance[4:], noise[4:], rtol=0.06)


@pytest.mark.parametrize("count", [233, 1024])
def test_rays_of_a_lattice_differ_by_no_more_than_is_reckoned(count: int) -> None:
    """And by no less than a third of it, whether a wavelet gets a ray of each row or thirty."""
    rows = under_open_sky(count)
    variance, noise = coefficients(rows, DEPTH).var(axis=0), reckoned(rows, DEPTH)
    for level in range(2, DEPTH):
        span = slice(4**level, 4 ** (level + 1))
        ratio = variance[span].sum() / noise[span].sum()
        assert 0.33 < ratio < 1.1, f"level {level}: {ratio:.2f}"
