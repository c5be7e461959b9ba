"""Eigenpairs of a symmetric matrix whose rows can be mirrored in two ways without changing it.

Such a matrix falls apart into four, one for the vectors that are even or odd under either mirror,
each with a quarter of the rows: a sixteenth of the work. Eigenvectors of one eigenvalue that differ
by their parity come out apart, where an iterative solver may miss one or turn them into each other.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

Mirrors = tuple[NDArray[np.int64], NDArray[np.int64]]


def is_mirrored(matrix: NDArray[np.floating], mirrors: Mirrors) -> bool:
    """Whether a matrix (m, m) is the same but for rounding after either permutation (m,)."""
    scale = float(np.abs(matrix).max(initial=0))
    return all(
        np.allclose(matrix[mirror][:, mirror], matrix, rtol=1e-4, atol=1e-6 * scale)
        for mirror in mirrors
    )


def largest_eigenpairs(
    matrix: NDArray[np.float64], mirrors: Mirrors | None, count: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(values (k,), orthonormal vectors (m, k)), the `count` largest in magnitude first, or all.

    matrix (m, m) is symmetric and unchanged by the mirrors, permutations that are their own inverse
    and commute; without any all is done at once.
    """
    if mirrors is None:
        values, vectors = np.linalg.eigh(matrix)
        order = np.argsort(-np.abs(values), kind="stable")[:count]
        return values[order], vectors[:, order]
    rows = np.arange(len(matrix))
    first, second = mirrors
    orbits = np.stack([rows, first, second, first[second]])
    orbits = orbits[:, orbits.min(axis=0) == rows]
    found = []
    for a, b in product((1.0, -1.0), repeat=2):
        signs = np.array([1.0, a, b, a * b])
        found += _of_parity(matrix, orbits, signs)
    found.sort(key=lambda pair: -abs(pair[0]))
    chosen = found[:count]
    vectors = np.zeros((len(matrix), len(chosen)))
    for k, (_, members, signs, entries) in enumerate(chosen):
        for sign, row in zip(signs, members, strict=True):
            vectors[row, k] += sign * entries
    return np.array([value for value, *_ in chosen]), vectors


def _of_parity(
    matrix: NDArray[np.float64], orbits: NDArray[np.int64], signs: NDArray[np.float64]
) -> list[tuple[float, NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]]:
    """All (value, orbits (4, q), signs (4,), entries (q,)) of one parity."""
    # The length of a vector that has the signs at the members of an orbit, which may coincide.
    same = orbits[:, None] == orbits[None, :]
    square = np.einsum("g,h,ghq->q", signs, signs, same)
    orbits, length = orbits[:, square > 0.5], np.sqrt(square[square > 0.5])
    reduced = sum(s * matrix[np.ix_(orbits[0], row)] for s, row in zip(signs, orbits, strict=True))
    values, vectors = np.linalg.eigh(4 * np.asarray(reduced) / length[:, None] / length)
    return [(float(value), orbits, signs, vectors[:, k] / length) for k, value in enumerate(values)]
