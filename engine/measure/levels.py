"""One object at several levels of detail: with smooth normals, and about so many vertices.

Coarser levels are made by clustering vertices, finer ones by cutting every triangle in four.
Neither is what a modeller would make, but they cost what a model of their size costs.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.scene.normals import with_normals
from engine.scene.part import Part
from engine.scene.simplify import CLOSE, clustered, welded


def smooth(part: Part) -> Part:
    """The part with normals that are the same at all its vertices of a place, without creases."""
    return with_normals(part, crease_degrees=180.0)


def with_vertices(part: Part, count: int) -> Part:
    """The shape of the part in about `count` vertices, to within a hundredth or so."""
    positions, triangles = welded(part.positions, part.triangles)
    while len(positions) < (1 - CLOSE) * count:
        positions, triangles = subdivided(positions, triangles)
    if len(positions) > (1 + CLOSE) * count:
        positions, triangles, _ = clustered(positions, triangles, count)
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
