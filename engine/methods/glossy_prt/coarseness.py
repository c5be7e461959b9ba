"""How far off shadows are on coarse meshes, and of simpler ones, measured in each scene.

Transport is found at vertices and mixed between them (`glossy_prt` §4.3), so that shadows are as
sharp as the mesh is fine. Here irradiance is found anew in the middle of triangles and held against
the mean of what their corners have. Where visibility is that of a simpler model (§5.1), irradiance
at vertices is held against that of the scene itself.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from engine.methods.glossy_prt.vertices import LIFT, Vertices
from engine.methods.glossy_prt.visibility import TOGETHER, OpenParts
from engine.numerics import cube_map
from engine.scene.scene import Scene

PLACES = 64  # triangles, picked by their area
SIMPLER_PLACES = 256  # vertices
LAMPS = 64  # lights all over the sphere
RADIUS = np.radians(10)  # of each


def between_vertices(scene: Scene, vertices: Vertices, open_parts: OpenParts, n: int) -> float:
    """Relative L2 error of irradiance in the middle of triangles, under lamps of 10 degrees.

    open_parts (eye, normal) is that of `direct.Job`, for cube maps of n x n texels a face.
    """
    geometry = scene.geometry
    corners = geometry.positions[geometry.triangles].astype(np.float64)
    area = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    if not area.any():
        return 0.0
    picked = np.random.default_rng(0).choice(len(area), PLACES, p=area / area.sum())
    ours = vertices.corners[picked]
    normal = vertices.normal[ours].sum(axis=1)
    normal = normal / np.maximum(np.linalg.norm(normal, axis=1)[:, None], 1e-30)
    eye = corners[picked].mean(axis=1) + LIFT * scene.rays.epsilon * normal
    at_corners = _irradiance(
        vertices.eye[ours].reshape(-1, 3), vertices.normal[ours].reshape(-1, 3), open_parts, n
    )
    mixed = at_corners.reshape(PLACES, 3, LAMPS).mean(axis=1)
    true = _irradiance(eye.astype(np.float32), normal.astype(np.float32), open_parts, n)
    return _error(mixed, true)


def of_simpler(vertices: Vertices, simpler: OpenParts, exact: OpenParts, n: int) -> float:
    """Relative L2 error of irradiance at vertices, under the same lamps."""
    count = len(vertices.eye)
    picked = np.random.default_rng(0).choice(count, min(SIMPLER_PLACES, count), replace=False)
    ours, true = (
        _irradiance(vertices.eye[picked], vertices.normal[picked], open_parts, n)
        for open_parts in (simpler, exact)
    )
    return _error(ours, true)


def _error(found: NDArray[np.float32], true: NDArray[np.float32]) -> float:
    return float(np.linalg.norm(found - true)) / max(float(np.linalg.norm(true)), 1e-30)


def _irradiance(
    eye: NDArray[np.float32], normal: NDArray[np.float32], open_parts: OpenParts, n: int
) -> NDArray[np.float32]:
    """(places, LAMPS): of light from each lamp, up to a factor."""
    out = np.zeros((len(eye), LAMPS), np.float32)
    areas, lamps = cube_map.vector_areas(n).astype(np.float32), _lamps(n)
    for k in range(0, len(eye), TOGETHER):
        s = slice(k, k + TOGETHER)
        cosine = np.maximum(normal[s] @ areas.T, 0)
        out[s] = (open_parts(eye[s], normal[s]) * cosine) @ lamps
    return out


@cache
def _lamps(n: int) -> NDArray[np.float32]:
    """(6 n², LAMPS): which texels shine."""
    axis = np.random.default_rng(1).normal(size=(LAMPS, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    return (cube_map.directions(n) @ axis.T > np.cos(RADIUS)).astype(np.float32)
