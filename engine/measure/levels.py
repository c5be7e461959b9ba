"""One object at several levels of detail: with smooth normals, and about so many vertices.

Coarser levels are made by clustering (Rossignac and Borrel 1993, *Multi-Resolution 3D
Approximations for Rendering Complex Scenes*): vertices in one cell of a grid become one. Finer
levels are made by cutting every triangle in four. Neither is what a modeller would make, but they
cost what a model of their size costs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.scene.normals import with_normals
from engine.scene.part import Part

CLOSE = 0.01  # of the vertices asked for: near enough
TRIES = 40


def smooth(part: Part) -> Part:
    """The part with normals that are the same at all its vertices of a place, without creases."""
    return with_normals(part, crease_degrees=180.0)


def with_vertices(part: Part, count: int) -> Part:
    """The shape of the part in about `count` vertices, to within a hundredth or so."""
    positions, triangles = _welded(part.positions, part.triangles)
    while len(positions) < (1 - CLOSE) * count:
        positions, triangles = subdivided(positions, triangles)
    if len(positions) > (1 + CLOSE) * count:
        positions, triangles = clustered(positions, triangles, count)
    return smooth(Part(positions, triangles))


def subdivided(
    positions: NDArray[np.float64], triangles: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Every triangle cut in four at the middles of its edges; (v, 3) and (t, 3) as of a `Part`."""
    sides = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, index = np.unique(sides, axis=0, return_inverse=True)
    a, b, c = triangles.T
    ab, bc, ca = (len(positions) + index.reshape(-1, 3)).T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    finer = np.stack([np.stack(corners, axis=1) for corners in parts], axis=1)
    return np.concatenate([positions, positions[edges].mean(axis=1)]), finer.reshape(-1, 3)


def clustered(
    positions: NDArray[np.float64], triangles: NDArray[np.int64], count: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """About `count` vertices, each the mean of those in a cell of a cubic grid."""
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
    return _welded(means, cell[triangles])


def _welded(
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
