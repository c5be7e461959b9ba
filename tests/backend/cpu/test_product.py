"""The fast product equals the dense one of NumPy."""

from __future__ import annotations

import numpy as np
import pytest

from engine.backend.cpu.product import TILE, multiply

N = 256


def random_rows(tiles: int, seed: int = 1, longest: int = 60):
    rng = np.random.default_rng(seed)
    length = rng.integers(0, longest, tiles).astype(np.int32)
    q = int(length.sum())
    ids = np.concatenate([rng.permutation(N)[:k] for k in length] or [np.zeros(0, int)]).astype(
        np.int32
    )
    scale = rng.lognormal(0, 2, q).astype(np.float32)
    steps = rng.integers(-127, 128, (q, TILE)).astype(np.int8)
    return length, ids, scale, steps


def obvious(length, ids, scale, steps, light) -> np.ndarray:
    """(tiles, 3, 64) float64: a dense matrix times the light."""
    dense = np.zeros((len(length), TILE, N))
    tile = np.repeat(np.arange(len(length)), length)
    dense[tile, :, ids] = scale[:, None].astype(float) * steps
    return (dense @ light.astype(float)).transpose(0, 2, 1)


@pytest.mark.parametrize("tiles", [1, 3, 40, 500])
def test_equals_the_dense_product(tiles: int):
    rows = random_rows(tiles)
    light = np.random.default_rng(2).normal(size=(N, 3)).astype(np.float32)
    expected = obvious(*rows, light)
    found = multiply(*rows, light)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("rows", [1, 16, 63])
def test_the_first_rows_equal_those_of_the_whole(rows: int):
    matrix = random_rows(50)
    light = np.random.default_rng(3).normal(size=(N, 3)).astype(np.float32)
    whole, some = multiply(*matrix, light), multiply(*matrix, light, rows)
    assert some.shape == (50, 3, rows)
    np.testing.assert_allclose(some, whole[:, :, :rows], atol=1e-5 * np.abs(whole).max())


def test_same_bytes_whatever_the_threads(monkeypatch: pytest.MonkeyPatch):
    matrix = random_rows(200)
    light = np.random.default_rng(3).normal(size=(N, 3)).astype(np.float32)
    made = []
    for threads in ("1", "2", "3"):
        monkeypatch.setenv("RELIGHT_THREADS", threads)
        made.append(multiply(*matrix, light).tobytes())
    assert made[0] == made[1] == made[2]


def test_takes_arrays_of_any_layout():
    """Stored arrays are mapped and read-only; a light may be a slice."""
    matrix = random_rows(20)
    light = np.random.default_rng(3).normal(size=(N, 6)).astype(np.float32)[:, ::2]
    expected = multiply(*matrix, np.ascontiguousarray(light))
    for array in matrix:
        array.flags.writeable = False
    np.testing.assert_array_equal(multiply(*matrix, light), expected)


def test_no_light_and_no_rows_are_black():
    assert not multiply(*random_rows(10), np.zeros((N, 3), np.float32)).any()
    empty = random_rows(10, longest=1)
    assert not multiply(*empty, np.ones((N, 3), np.float32)).any()
