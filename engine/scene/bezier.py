"""Cubic Bézier splines, of curves and of patches, by Bernstein's polynomials.

A spline of K pieces has 3K + 1 control points: piece k has those from 3k to 3k + 3, so neighbours
share one. The parameter runs from 0 to K, through piece k from k to k + 1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray


def has_ends(points: list[Any]) -> list[Any]:
    """The control points of a description, once they are seen to make a spline."""
    if len(points) % 3 != 1:
        raise ValueError(f"{len(points)} points: cubic curves in a row have 4, 7, 10 and so on")
    for k in range(len(points) - 1):
        if k % 3 != 1 and points[k] == points[k + 1]:
            raise ValueError(f"points {k} and {k + 1} are the same: the curve has no direction")
    return points


def parameters(points: int, segments: int) -> NDArray[np.float64]:
    """(K segments + 1,) from 0 to K for so many control points: every piece in equal steps."""
    pieces = (points - 1) // 3
    return np.arange(pieces * segments + 1) / segments


def spline(
    points: NDArray[np.float64], t: NDArray[np.float64], order: int = 0
) -> NDArray[np.float64]:
    """(n, ...) at parameters t (n,) of control points (3K + 1, ...); its derivative for order 1.

    At whole numbers it is the control point to the last digit.
    """
    piece = np.minimum(t.astype(int), (len(points) - 1) // 3 - 1)
    weights = (_slopes if order else _weights)(t - piece)
    # One product after the other, so that equal points give equal sums wherever they lie.
    total = np.zeros((len(t), *points.shape[1:]))
    for k, weight in enumerate(weights):
        total += weight.reshape(-1, *[1] * (points.ndim - 1)) * points[3 * piece + k]
    return total


def surface(
    points: NDArray[np.float64],
    v: NDArray[np.float64],
    u: NDArray[np.float64],
    v_order: int = 0,
    u_order: int = 0,
) -> NDArray[np.float64]:
    """(m, n, 3) at all pairs of v (m,) and u (n,): the tensor product of two splines.

    points is (3K + 1, 3L + 1, 3), v running along the first axis; derivatives as of `spline`.
    """
    rows = np.swapaxes(spline(points, v, v_order), 0, 1)
    return np.swapaxes(spline(rows, u, u_order), 0, 1)


def _weights(x: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Bernstein's polynomials of degree 3."""
    y = 1 - x
    return y**3, 3 * x * y**2, 3 * x**2 * y, x**3


def _slopes(x: NDArray[np.float64]) -> tuple[NDArray[np.float64], ...]:
    """Their derivatives."""
    y = 1 - x
    return -3 * y**2, 3 * y * (y - 2 * x), 3 * x * (2 * y - x), 3 * x**2
