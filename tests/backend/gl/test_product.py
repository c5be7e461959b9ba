"""Transform and product on the GPU equal those on the CPU."""

from __future__ import annotations

import numpy as np
import pytest
from backend.cpu.test_product import random_light, random_rows, random_steps, shuffled

from engine.backend.cpu.product import multiply
from engine.backend.gl.context import Device
from engine.backend.gl.haar import Haar
from engine.backend.gl.product import Places, Rows
from engine.methods.fixed_view.rows import PackedRows, no_rows
from engine.numerics import haar
from engine.numerics.packed import TILE

pytestmark = pytest.mark.gl


@pytest.mark.parametrize("levels", [1, 2, 3, 6, 8])
def test_haar(gpu: Device, levels: int) -> None:
    n = 4**levels
    values = np.random.default_rng(levels).normal(size=(n, 3)).astype(np.float32)
    out = gpu.floats(3 * n)
    Haar(gpu, n).forward(gpu.upload(values), out)
    found = np.frombuffer(out.read(), np.float32)[: 3 * n].reshape(n, 3)
    expected = haar.forward(values)
    np.testing.assert_allclose(found, expected, atol=2e-7 * np.abs(expected).max())


def product(gpu: Device, matrix: PackedRows, light: np.ndarray, places: np.ndarray) -> np.ndarray:
    out = gpu.floats(3 * places.size)
    Rows(gpu, *matrix).multiply(gpu.upload(light), Places(gpu, places), out)
    return np.frombuffer(out.read(12 * places.size), np.float32).reshape(-1, 3)


@pytest.mark.parametrize("tiles", [1, 3, 500])
@pytest.mark.parametrize("rows", [TILE, TILE // 4])
@pytest.mark.parametrize("longest", [5, 60])
def test_product(gpu: Device, tiles: int, rows: int, longest: int) -> None:
    matrix, places, light = random_rows(tiles, 1, longest), shuffled(tiles, rows), random_light()
    places[np.random.default_rng(2).random(places.shape) < 0.1] = -1
    found = product(gpu, matrix, light, places)
    expected = multiply(*matrix, light, places, places.size)
    assert np.linalg.norm(found - expected) < 1e-6 * np.linalg.norm(expected)
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


@pytest.mark.parametrize("kind", range(4))
@pytest.mark.parametrize("count", [1, 3, 4, 63, 64, 65, 200])
def test_lists_of_one_kind(gpu: Device, kind: int, count: int) -> None:
    """As many wavelets as are taken at once, one less, one more."""
    rng = np.random.default_rng(count)
    length = np.zeros((2, 4), np.int32)
    length[:, kind] = count, count + 1
    q = int(length.sum())
    matrix = PackedRows(
        length, rng.integers(0, 256, q).astype(np.int32), rng.normal(size=q).astype(np.float32),
        rng.lognormal(0, 1, int(length[:, :-1].sum())).astype(np.float32),
        random_steps(length, rng),
    )  # fmt: skip
    places, light = shuffled(2), random_light()
    found = product(gpu, matrix, light, places)
    expected = multiply(*matrix, light, places, places.size)
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


def test_empty_rows(gpu: Device) -> None:
    """Zeros are written, whatever lay there before."""
    out = gpu.upload(np.ones((3 * TILE, 3), np.float32))
    Rows(gpu, *no_rows(3)).multiply(gpu.floats(3), Places(gpu, shuffled(3)), out)
    assert not np.frombuffer(out.read(), np.float32).any()
