"""A piece of geometry with one material, before it becomes part of a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class Part:
    """Triangles in the coordinates of their own file or shape.

    positions  (v, 3) float64
    triangles  (t, 3) int64            counter-clockwise seen from outside
    normals    (v, 3) float64 or None  unit length; None where the file has none
    uvs        (v, 2) float64 or None  texture coordinates, origin at the lower left
    material   name among the materials of the same file; None where the file names none
    """

    positions: NDArray[np.float64]
    triangles: NDArray[np.int64]
    normals: NDArray[np.float64] | None = None
    uvs: NDArray[np.float64] | None = None
    material: str | None = None


def grid_triangles(rows: int, columns: int) -> NDArray[np.int64]:
    """Triangles of a grid of (rows + 1) x (columns + 1) vertices, row by row from the bottom."""
    i, j = np.mgrid[0:rows, 0:columns].reshape(2, -1)
    a = i * (columns + 1) + j
    b, c, d = a + 1, a + columns + 2, a + columns + 1
    return np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def with_corners(positions: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.int64]:
    """The triangles of which no two corners coincide: a grid has others where it has a pole."""
    a, b, c = (positions[triangles[:, k]] for k in range(3))
    same = (a == b).all(axis=1) | (b == c).all(axis=1) | (c == a).all(axis=1)
    return triangles[~same]


def joined(parts: Sequence[Part]) -> Part:
    """Parts that have normals and texture coordinates, as one."""
    starts = np.cumsum([0] + [len(part.positions) for part in parts[:-1]])
    return Part(
        np.concatenate([part.positions for part in parts]),
        np.concatenate([part.triangles + start for part, start in zip(parts, starts, strict=True)]),
        np.concatenate([part.normals for part in parts if part.normals is not None]),
        np.concatenate([part.uvs for part in parts if part.uvs is not None]),
    )
