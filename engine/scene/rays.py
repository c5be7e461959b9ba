"""Ray queries by Embree: the only user of embreex.

A query is batched and spread over threads (embreex releases the interpreter lock). Arrays must be
contiguous float32, else every call pays for a conversion.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from numpy.typing import NDArray

from engine.errors import SceneError
from engine.numerics.parallel import for_ranges

GRAIN = 4096


class Hits(NamedTuple):
    """Nearest hits of n rays.

    distance  (n,) float32   in units of the direction's length; infinity where nothing is hit
    triangle  (n,) int32     -1 where nothing is hit
    b1, b2    (n,) float32   barycentrics of the triangle's second and third vertex
    """

    distance: NDArray[np.float32]
    triangle: NDArray[np.int32]
    b1: NDArray[np.float32]
    b2: NDArray[np.float32]


class RayTracer:
    """Rays against a fixed set of triangles.

    Rays start exactly at their origin: move origins off the surface with `epsilon` (metres, along
    the geometric normal) before asking, or they hit the surface they leave.
    """

    def __init__(self, positions: NDArray[np.float32], triangles: NDArray[np.int32]) -> None:
        """Build the tree over positions (v, 3) float32 and triangles (t, 3) int32."""
        if len(triangles) == 0:
            raise SceneError("the scene has no triangles")
        self._triangles = positions, triangles
        self._scene = EmbreeScene(robust=True)
        self._mesh = TriangleMesh(
            self._scene,
            np.ascontiguousarray(positions, np.float32),
            np.ascontiguousarray(triangles, np.int32),
        )
        low, high = positions.min(axis=0), positions.max(axis=0)
        reach = max(float(np.abs(low).max()), float(np.abs(high).max()))
        self.epsilon = max(1e-5 * float(np.linalg.norm(high - low)), 4e-7 * reach, 1e-12)
        # Embree commits at the first query, which two threads must not do at once.
        self._run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32), np.ones(1, np.float32))

    def __reduce__(self) -> tuple[type[RayTracer], tuple[NDArray[np.float32], NDArray[np.int32]]]:
        """Another process builds the tree anew."""
        return RayTracer, self._triangles

    def intersect(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        limit: float | NDArray[np.float32] = np.inf,
    ) -> Hits:
        """Nearest hit closer than `limit`, in units of the direction's length.

        origins, directions (n, 3) float32 contiguous; limit a number or (n,) float32.
        """
        n = len(origins)
        limits = np.full(n, limit, np.float32) if np.isscalar(limit) else np.asarray(limit)
        distance, triangle = np.full(n, np.inf, np.float32), np.full(n, -1, np.int32)
        b1, b2 = np.zeros(n, np.float32), np.zeros(n, np.float32)

        def part(start: int, stop: int) -> None:
            s = slice(start, stop)
            # Embree overwrites the limits it is given, so it gets a copy.
            hit = self._scene.run(
                origins[s], directions[s], dists=limits[s].copy(), query="INTERSECT", output=True
            )
            triangle[s], b1[s], b2[s] = hit["primID"], hit["u"], hit["v"]
            found = triangle[s] >= 0
            distance[s][found] = hit["tfar"][found]

        for_ranges(part, n, grain=GRAIN)
        return Hits(distance, triangle, b1, b2)

    def occluded(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        limit: float | NDArray[np.float32] = np.inf,
    ) -> NDArray[np.bool_]:
        """Whether anything is hit closer than `limit`; shapes as for `intersect`. (n,) bool."""
        n = len(origins)
        limits = np.full(n, limit, np.float32) if np.isscalar(limit) else np.asarray(limit)
        out = np.zeros(n, np.bool_)

        def part(start: int, stop: int) -> None:
            s = slice(start, stop)
            out[s] = self._run(origins[s], directions[s], limits[s].copy()) >= 0

        for_ranges(part, n, grain=GRAIN)
        return out

    def _run(
        self,
        origins: NDArray[np.float32],
        directions: NDArray[np.float32],
        limits: NDArray[np.float32],
    ) -> NDArray[np.int32]:
        return self._scene.run(origins, directions, dists=limits, query="OCCLUDED")
