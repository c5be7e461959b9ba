"""Boxes around points (kernels)."""

from __future__ import annotations

from numba import njit


@njit
def widest(values, rows):
    """The column of values (n, k) in which some of its rows (m,) differ most."""
    axis, best = 0, -1.0
    for k in range(values.shape[1]):
        low = high = values[rows[0], k]
        for i in rows:
            low, high = min(low, values[i, k]), max(high, values[i, k])
        if high - low > best:
            axis, best = k, high - low
    return axis
