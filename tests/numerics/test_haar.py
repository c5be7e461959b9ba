"""Laws of the Haar transform in quad-tree order, and its formulas as a dense matrix beside it."""

from __future__ import annotations

import numpy as np
import pytest

from engine.numerics import haar

SIZES = [4**k for k in range(7)]


def dense(n: int) -> np.ndarray:
    """(n, n) float64 analysis matrix, row by row from the docstring's formulas alone."""
    matrix = np.zeros((n, n))
    matrix[0] = n**-0.5
    signs = ((1, -1, 1, -1), (1, 1, -1, -1), (1, -1, -1, 1))
    level = 0
    while 4**level < n:
        under = n // 4**level
        for node in range(4**level):
            for kind in range(3):
                row = np.repeat(signs[kind], under // 4) / np.sqrt(under)
                matrix[4**level + 3 * node + kind, node * under : (node + 1) * under] = row
        level += 1
    return matrix


def random(n: int, channels: int = 3, seed: int = 1) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(n, channels)).astype(np.float32)


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("channels", [1, 3])
@pytest.mark.parametrize("dtype", [np.float32, np.float64])
def test_reconstructs_and_keeps_energy(n: int, channels: int, dtype: type) -> None:
    values = random(n, channels).astype(dtype)
    coefficients = haar.forward(values)
    assert coefficients.dtype == dtype
    precision = 2e-5 if dtype is np.float32 else 1e-12
    np.testing.assert_allclose(haar.inverse(coefficients), values, atol=precision)
    np.testing.assert_allclose(haar.forward(haar.inverse(values)), values, atol=precision)
    np.testing.assert_allclose((coefficients**2).sum(0), (values**2).sum(0), rtol=10 * precision)


@pytest.mark.parametrize("n", [1, 4, 16, 256])
def test_is_the_matrix_of_its_formulas(n: int) -> None:
    matrix = dense(n)
    np.testing.assert_allclose(matrix @ matrix.T, np.eye(n), atol=1e-12)
    np.testing.assert_allclose(haar.forward(np.eye(n)), matrix, atol=1e-12)
    np.testing.assert_allclose(haar.inverse(np.eye(n)), matrix.T, atol=1e-12)


def test_is_linear() -> None:
    a, b = random(1024, seed=1), random(1024, seed=2)
    np.testing.assert_allclose(
        haar.forward(3 * a - 2 * b), 3 * haar.forward(a) - 2 * haar.forward(b), atol=1e-4
    )


def test_does_not_touch_its_input() -> None:
    values = random(64)
    copy = values.copy()
    haar.forward(values)
    haar.inverse(values)
    np.testing.assert_array_equal(values, copy)


def test_takes_columns_of_a_larger_array() -> None:
    values = random(64, 6)
    np.testing.assert_array_equal(
        haar.forward(values[:, ::2]), haar.forward(np.ascontiguousarray(values[:, ::2]))
    )


def test_a_wavelet_lies_within_its_node() -> None:
    """Coefficient 4^l + 3i + kind touches the run of node i of level l and nothing else."""
    n = 256
    basis = haar.inverse(np.eye(n))
    for level in range(4):
        under = n // 4**level
        for node in range(4**level):
            for kind in range(3):
                (touched,) = np.nonzero(basis[:, 4**level + 3 * node + kind])
                np.testing.assert_array_equal(touched, np.arange(node * under, (node + 1) * under))


@pytest.mark.parametrize("n", SIZES)
def test_a_constant_is_scaling_alone(n: int) -> None:
    coefficients = haar.forward(np.full((n, 1), 3, np.float32))
    assert coefficients[0, 0] == pytest.approx(3 * np.sqrt(n))
    assert not coefficients[1:].any()


@pytest.mark.parametrize("n", [0, 2, 3, 8, 32, 100, 4**6 + 1])
def test_only_powers_of_four(n: int) -> None:
    with pytest.raises(ValueError, match="power of four"):
        haar.levels(n)


@pytest.mark.parametrize("k", range(12))
def test_levels(k: int) -> None:
    assert haar.levels(4**k) == k
