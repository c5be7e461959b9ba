"""The equal-area square of the sphere: there and back, areas, neighbours."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from engine.numerics.octahedron import cell, centres, direction, square
from engine.numerics.vec import vec


@njit
def cells(d, depth, out):
    for i in range(len(d)):
        out[i] = cell(vec(d, i), depth)


@njit
def there_and_back(d, out):
    for i in range(len(d)):
        u, v = square(vec(d, i))
        out[i, 0], out[i, 1], out[i, 2] = direction(u, v)


def found(d: np.ndarray, depth: int) -> np.ndarray:
    out = np.zeros(len(d), np.int64)
    cells(d, depth, out)
    return out


def unit(n: int) -> np.ndarray:
    d = np.random.default_rng(1).normal(size=(n, 3))
    return d / np.linalg.norm(d, axis=1, keepdims=True)


AXES = np.concatenate([np.eye(3), -np.eye(3)])


def test_there_and_back() -> None:
    d = np.concatenate([unit(10000), AXES])
    out = np.zeros_like(d)
    there_and_back(d, out)
    np.testing.assert_allclose(out, d, atol=1e-7)


@pytest.mark.parametrize("depth", [0, 1, 4, 7])
def test_every_cell_holds_its_centre(depth: int) -> None:
    d = centres(depth)
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, rtol=1e-12)
    np.testing.assert_array_equal(found(d, depth), np.arange(4**depth))
    assert found(AXES, depth).max() < 4**depth


def test_cells_have_equal_areas() -> None:
    """A million even directions: as many in each of 64 cells but for their noise of 0.8 %."""
    counts = np.bincount(found(unit(1_000_000), 3), minlength=64)
    assert np.abs(counts / counts.mean() - 1).max() < 0.035


def test_a_parent_is_around_its_children() -> None:
    """Quad-tree order: dropping two bits of a cell gives the cell of the coarser square."""
    d = unit(20000)
    np.testing.assert_array_equal(found(d, 6) >> 2, found(d, 5))
    # Cells are compact: no direction is farther from its centre than 3.4 times their radius.
    off = np.arccos(np.clip((centres(5)[found(d, 5)] * d).sum(axis=1), -1, 1))
    assert off.max() < 3.4 * np.sqrt(4 / 4**5)
