"""Transform and product on the GPU equal those on the CPU."""

from __future__ import annotations

import numpy as np
import pytest

from engine.backend.cpu.product import COARSE, TILE, multiply
from engine.backend.gl.context import Device
from engine.backend.gl.haar import Haar
from engine.backend.gl.product import Places, Rows
from engine.numerics import haar

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


@pytest.mark.parametrize("tiles", [1, 3, 500])
@pytest.mark.parametrize("rows", [TILE, COARSE])
def test_product(gpu: Device, tiles: int, rows: int) -> None:
    rng = np.random.default_rng(tiles)
    n_g = 256
    length = rng.integers(0, 200, tiles).astype(np.int32)
    length[0] = 137
    q = int(length.sum())
    matrix = (
        length,
        rng.integers(0, n_g, q).astype(np.int32),
        rng.lognormal(0, 2, q).astype(np.float32),
        rng.integers(-127, 128, (q, TILE)).astype(np.int8),
    )
    light = rng.normal(size=(n_g, 3)).astype(np.float32)
    n = tiles * rows + 5
    places = rng.permutation(n)[: tiles * rows].reshape(tiles, rows).astype(np.int32)
    places[rng.random(places.shape) < 0.1] = -1
    out = gpu.floats(3 * n)
    Rows(gpu, *matrix).multiply(gpu.upload(light), Places(gpu, places), out)
    found = np.frombuffer(out.read(), np.float32)[: 3 * n].reshape(n, 3)
    expected = multiply(*matrix, light, places, n)
    assert np.linalg.norm(found - expected) < 1e-6 * np.linalg.norm(expected)
    np.testing.assert_allclose(found, expected, atol=1e-5 * np.abs(expected).max())


def test_empty_rows(gpu: Device) -> None:
    empty = (
        np.zeros(3, np.int32), np.zeros(0, np.int32), np.zeros(0, np.float32),
        np.zeros((0, TILE), np.int8),
    )  # fmt: skip
    places = np.arange(3 * TILE, dtype=np.int32).reshape(3, TILE)
    out = gpu.upload(np.ones((3 * TILE, 3), np.float32))
    Rows(gpu, *empty).multiply(gpu.floats(3), Places(gpu, places), out)
    assert not np.frombuffer(out.read(), np.float32).any()
