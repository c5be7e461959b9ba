"""A piece of geometry with one material, before it becomes part of a scene."""

from __future__ import annotations

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
