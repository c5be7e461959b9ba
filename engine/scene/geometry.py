"""Put parts into the world and lay them out flat."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.scene.part import Part
from engine.scene.scene import Geometry

Placed = tuple[Part, NDArray[np.float64], int, int]
"""A part, its (4, 4) matrix to the world, the index of its material and that of its object."""


def placed_part(part: Part, matrix: NDArray[np.float64]) -> Part:
    """The part in the world. A mirroring matrix turns the triangles round to keep them outward."""
    linear = matrix[:3, :3]
    positions = part.positions @ linear.T + matrix[:3, 3]
    triangles = part.triangles[:, ::-1] if np.linalg.det(linear) < 0 else part.triangles
    normals = part.normals
    if normals is not None:
        # Normals go by the inverse transpose, so that they stay normal under uneven scales.
        normals = normals @ np.linalg.inv(linear)
        length = np.linalg.norm(normals, axis=1, keepdims=True)
        normals = normals / np.where(length > 0, length, 1)
    return Part(positions, triangles, normals, part.uvs, part.material)


def assemble(placed: Sequence[Placed]) -> Geometry:
    """All parts in one set of flat arrays; every part must have normals and coordinates."""
    parts = [placed_part(part, matrix) for part, matrix, _, _ in placed]
    starts = np.cumsum([0] + [len(part.positions) for part in parts])
    counts = [len(part.triangles) for part in parts]

    def flat(arrays: list[NDArray], dtype: type) -> NDArray:
        return np.ascontiguousarray(np.concatenate(arrays), dtype)

    return Geometry(
        flat([part.positions for part in parts], np.float32),
        flat([p.triangles + start for p, start in zip(parts, starts[:-1], strict=True)], np.int32),
        flat([part.normals for part in parts if part.normals is not None], np.float32),
        flat([part.uvs for part in parts if part.uvs is not None], np.float32),
        np.repeat([material for _, _, material, _ in placed], counts).astype(np.int32),
        np.repeat([index for _, _, _, index in placed], counts).astype(np.int32),
    )
