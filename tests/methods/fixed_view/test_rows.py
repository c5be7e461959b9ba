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
    projected,
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
