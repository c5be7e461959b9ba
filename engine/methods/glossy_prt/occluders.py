"""What blocks the sky: the scene's triangles, or a simpler model of them (`glossy_prt` §4.1, §5.1).

A simpler surface lies above some vertices and below others. So that these do not block one another,
what is nearer than half a cell of the grid that its vertices were merged in does not block.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.scene.rays import RayTracer
from engine.scene.scene import Scene
from engine.scene.simplify import clustered

SKIPPED = 0.5  # of a cell: less error on the bunny than with 0, 1 or 2


class Occluders(NamedTuple):
    """Triangles that visibility is looked for in.

    positions  (v, 3) float32   metres
    triangles  (t, 3) int32
    rays       the ray tracer over them
    skip       metres from an eye within which nothing blocks
    """

    positions: NDArray[np.float32]
    triangles: NDArray[np.int32]
    rays: RayTracer
    skip: float

    def blocks(
        self, eye: NDArray[np.float32], directions: NDArray[np.float32]
    ) -> NDArray[np.bool_]:
        """(n,): whether something stands in the way of directions (n, 3) from eyes (n, 3)."""
        start = eye + np.float32(self.skip) * directions if self.skip else eye
        return self.rays.occluded(start, directions)


def occluders(scene: Scene, vertices: int = 0) -> Occluders:
    """The scene's triangles, or about so many vertices for each object that has more; 0 for all."""
    geometry = scene.geometry
    if vertices == 0:
        return Occluders(geometry.positions, geometry.triangles, scene.rays, 0.0)
    positions, triangles, count, largest = [], [], 0, 0.0
    for number in np.unique(geometry.object):
        used, index = np.unique(geometry.triangles[geometry.object == number], return_inverse=True)
        places, corners = geometry.positions[used].astype(np.float64), index.reshape(-1, 3)
        if len(places) > vertices:
            places, corners, size = clustered(places, corners, vertices)
            largest = max(largest, size)
        positions.append(places)
        triangles.append(corners + count)
        count += len(places)
    p = np.concatenate(positions).astype(np.float32)
    t = np.concatenate(triangles).astype(np.int32)
    return Occluders(p, t, RayTracer(p, t), SKIPPED * largest)
