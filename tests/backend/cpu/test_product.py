"""The fast product equals the dense one of NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from methods.fixed_view.gather_matrix import unpacked

from engine.backend.cpu.product import multiply
from engine.methods.fixed_view.rows import PackedRows
from engine.numerics.packed import STEPS, TILE

N = 256


def random_steps(length: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """(bytes,) int8: steps for lists of these lengths, the first of every wavelet 0."""
    count = np.concatenate([np.repeat(STEPS, row) for row in length])
    steps = rng.integers(-127, 128, count.sum()).astype(np.int8)
    steps[(np.cumsum(count) - count)[count > 0]] = 0
    return steps


def random_rows(tiles: int, seed: int = 1, longest: int = 20) -> PackedRows:
    rng = np.random.default_rng(seed)
    length = rng.integers(0, longest, (tiles, len(STEPS))).astype(np.int32)
    ids = [rng.permutation(N)[: row.sum()] for row in length]
    q = int(length.sum())
    return PackedRows(
        length,
        np.concatenate(ids or [np.zeros(0, int)]).astype(np.int32),
        rng.normal(size=q).astype(np.float32),
        rng.lognormal(0, 2, int(length[:, :-1].sum())).astype(np.float32),
        random_steps(length, rng),
    )


def shuffled(tiles: int, rows: int = TILE) -> np.ndarray:
    """(tiles, rows) int32: a place for every row of every tile, in no order."""
    order = np.random.default_rng(4).permutation(tiles * rows)
    return order.reshape(tiles, rows).astype(np.int32)


def random_light(seed: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(N, 3)).astype(np.float32)


def obvious(matrix: PackedRows, light: np.ndarray) -> np.ndarray:
    """(tiles, 64, 3) float64: a dense matrix times the light."""
    return (unpacked(matrix, N) @ light.astype(float)).reshape(-1, TILE, 3)


@pytest.mark.parametrize("tiles", [1, 3, 40, 500])
@pytest.mark.parametrize("rows", [TILE, TILE // 4])
def test_equals_the_dense_product(tiles: int, rows: int):
    matrix, places = random_rows(tiles), shuffled(tiles, rows)
    light = random_light()
    expected = obvious(matrix, light)[:, :: TILE // rows].reshape(-1, 3)
    found = multiply(*matrix, light, places, places.size)
    assert found.dtype == np.float32
    np.testing.assert_allclose(found[places.ravel()], expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("kind", range(len(STEPS)))
@pytest.mark.parametrize("count", range(10))
def test_lists_of_every_length(kind: int, count: int):
    """Wavelets are taken four at a time; what is left over counts once."""
    rng = np.random.default_rng(count)
    length = np.zeros((1, len(STEPS)), np.int32)
    length[0, kind] = count
    matrix = PackedRows(
        length, rng.permutation(N)[:count].astype(np.int32), np.ones(count, np.float32),
        np.ones(count if STEPS[kind] else 0, np.float32), random_steps(length, rng),
    )  # fmt: skip
    light = random_light()
    found = multiply(*matrix, light, shuffled(1), TILE)
    expected = obvious(matrix, light)[0]
    np.testing.assert_allclose(found[shuffled(1)[0]], expected, atol=1e-2)


def test_a_row_without_a_place_is_left_out():
    matrix, places, light = random_rows(5), shuffled(5), random_light()
    whole = multiply(*matrix, light, places, places.size)
    some = places.copy()
    some[2, 10:] = -1
    found = multiply(*matrix, light, some, places.size)
    assert not found[places[2, 10:]].any()
    kept = np.setdiff1d(places.ravel(), places[2, 10:])
    np.testing.assert_array_equal(found[kept], whole[kept])


def test_same_bytes_whatever_the_threads(monkeypatch: pytest.MonkeyPatch):
    matrix, places = random_rows(200), shuffled(200)
    made = []
    for threads in ("1", "2", "3"):
        monkeypatch.setenv("RELIGHT_THREADS", threads)
        made.append(multiply(*matrix, random_light(), places, places.size).tobytes())
    assert made[0] == made[1] == made[2]


def test_takes_arrays_of_any_layout():
    """Stored arrays are mapped and read-only; a light may be a slice."""
    matrix, places = random_rows(20), shuffled(20)
    light = np.random.default_rng(3).normal(size=(N, 6)).astype(np.float32)[:, ::2]
    expected = multiply(*matrix, np.ascontiguousarray(light), places, places.size)
    for array in matrix:
        array.flags.writeable = False
    np.testing.assert_array_equal(multiply(*matrix, light, places, places.size), expected)


def test_no_light_and_no_rows_are_black():
    places = shuffled(10)
    assert not multiply(*random_rows(10), np.zeros((N, 3), np.float32), places, 640).any()
    empty = random_rows(10, longest=1)
    assert not multiply(*empty, np.ones((N, 3), np.float32), places, 640).any()
