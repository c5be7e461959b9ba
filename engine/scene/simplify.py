"""Meshes of fewer vertices.

Rossignac and Borrel 1993, *Multi-Resolution 3D Approximations for Rendering Complex Scenes*:
vertices in one cell of a grid become one.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

CLOSE = 0.01  # of the vertices asked for: near enough
TRIES = 40


def clustered(
    positions: NDArray[np.float64], triangles: NDArray[np.int64], count: int
) -> tuple[NDArray[np.float64], NDArray[np.int64], float]:
    """About `count` vertices, each the mean of those in a cell of a cubic grid, and its size."""
    low = positions.min(axis=0)
    small, large = 0.0, float((positions.max(axis=0) - low).max())
    # Bisect the size of the cells.
    for _ in range(TRIES):
        size = (small + large) / 2
        # What reaches farthest lies in the middle of a cell, not in a sliver of one.
        numbers = np.rint((positions - low) / size).astype(np.int64)
        cells, cell = np.unique(numbers, axis=0, return_inverse=True)
        if abs(len(cells) - count) <= CLOSE * count:
            break
        small, large = (size, large) if len(cells) > count else (small, size)
    cell = cell.reshape(-1)
    means = np.zeros((len(cells), 3))
    np.add.at(means, cell, positions)
    means /= np.bincount(cell)[:, None]
    return *welded(means, cell[triangles]), size


def welded(
    positions: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """One vertex at every place that a triangle uses, and no triangle twice or without area."""
    positions, place = np.unique(positions, axis=0, return_inverse=True)
    triangles = place.reshape(-1)[triangles]
    a, b, c = triangles.T
    triangles = triangles[(a != b) & (b != c) & (c != a)]
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    triangles = triangles[np.sort(first)]
    used, index = np.unique(triangles, return_inverse=True)
    return positions[used], index.reshape(-1, 3)
