"""A matrix with two mirrors has the eigenpairs that a solver finds which knows nothing of them."""

from __future__ import annotations

import numpy as np
import pytest

from engine.numerics.mirrors import is_mirrored, largest_eigenpairs


def grid(rows: int, columns: int) -> tuple[np.ndarray, np.ndarray]:
    """Left and right, up and down of a picture; odd sides have texels that stay in place."""
    number = np.arange(rows * columns).reshape(rows, columns)
    return number[:, ::-1].ravel(), number[::-1].ravel()


@pytest.mark.parametrize("size", [(4, 6), (3, 4), (5, 3), (1, 1)])
def test_as_the_whole(size: tuple[int, int]) -> None:
    mirrors, m = grid(*size), size[0] * size[1]
    a = np.random.default_rng(1).normal(size=(m, m))
    a = a + a.T
    for mirror in mirrors:
        a = a + a[mirror][:, mirror]
    assert is_mirrored(a, mirrors)
    values, vectors = largest_eigenpairs(a, mirrors, m)
    assert len(values) == m
    np.testing.assert_allclose(np.sort(values), np.linalg.eigvalsh(a), atol=1e-10)
    assert (np.diff(np.abs(values)) <= 1e-12).all()
    np.testing.assert_allclose(vectors.T @ vectors, np.eye(m), atol=1e-10)
    np.testing.assert_allclose(vectors * values @ vectors.T, a, atol=1e-10)
    some, _ = largest_eigenpairs(a, mirrors, min(3, m))
    np.testing.assert_allclose(some, values[:3])
    other, _ = largest_eigenpairs(a, None, m)
    np.testing.assert_allclose(np.abs(other), np.abs(values), atol=1e-10)


def test_every_eigenvector_is_even_or_odd() -> None:
    mirrors = grid(4, 4)
    values, vectors = largest_eigenpairs(np.eye(16), mirrors, 16)  # one eigenvalue, 16 times
    np.testing.assert_allclose(values, 1)
    for mirror in mirrors:
        parity = np.einsum("mk,mk->k", vectors[mirror], vectors)
        np.testing.assert_allclose(np.abs(parity), 1)


def test_a_matrix_without_mirrors_is_known() -> None:
    a = np.random.default_rng(2).normal(size=(16, 16))
    assert not is_mirrored(a + a.T, grid(4, 4))
