"""The reference of `wavelet_brdf`: point lights reflected once, by what a material is itself.

Rays are cast through every pixel and to every light, and f comes from the measurement or from the
model, pair by pair, with no code in between (Claustres, Barthe, Paulin 2007, §6.3, eq. 1).
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.base import GRAIN, to_grain
from engine.errors import InputError
from engine.light.point import PointLight
from engine.methods.fixed_view.frame_buffer import Points, describe, no_points
from engine.methods.wavelet_brdf.codes import source_of
from engine.numerics.frames import tangents, to_local
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec
from engine.scene.rays import Hits
from engine.scene.scene import Scene


def cast(scene: Scene, grid: int = 1, *, shadows: bool = True) -> NDArray[np.float32]:
    """(h, w, 3) radiance, black where nothing is: the mean of grid² rays through every pixel."""
    height, width = scene.camera.height, scene.camera.width
    total = np.zeros((height * width, 3))
    offsets = (np.arange(grid) + 0.5) / grid
    for dy in offsets:
        for dx in offsets:
            points, hits = _seen(scene, dx, dy)
            there = np.flatnonzero(hits.triangle >= 0)
            total[there] += radiance(scene, points.take(there), shadows=shadows)
    return (total / grid**2).reshape(height, width, 3).astype(np.float32)


def per_vertex(scene: Scene, *, shadows: bool = True) -> NDArray[np.float32]:
    """(h, w, 3): eq. 1 at the vertices, and interpolated between them; materials without grain."""
    geometry = scene.geometry
    points = no_points(len(geometry.positions))
    points.position[:], points.normal[:] = geometry.positions, geometry.normals
    points.geometric[:] = geometry.normals
    away = geometry.positions - np.array(scene.camera.position, np.float32)
    points.view[:] = -away / np.linalg.norm(away, axis=1, keepdims=True)
    points.material[geometry.triangles] = geometry.material[:, None]
    colour = radiance(scene, points, shadows=shadows)
    _, hits = _seen(scene, 0.5, 0.5)
    there = hits.triangle >= 0
    corners = colour[geometry.triangles[hits.triangle[there]]]
    b1, b2 = hits.b1[there, None], hits.b2[there, None]
    out = np.zeros((len(there), 3), np.float32)
    out[there] = (1 - b1 - b2) * corners[:, 0] + b1 * corners[:, 1] + b2 * corners[:, 2]
    return out.reshape(scene.camera.height, scene.camera.width, 3)


def radiance(scene: Scene, points: Points, *, shadows: bool) -> NDArray[np.float64]:
    """(n, 3) of the scene's point lights at points of surfaces."""
    out = np.zeros((len(points.material), 3))
    for light in scene.lights:
        if not isinstance(light, PointLight):
            raise InputError("the reference knows point lights alone", field="lights")
        way = np.array(light.position) - points.position
        distance = np.linalg.norm(way, axis=1)
        way /= distance[:, None]
        wi, wo = (_local(points, w) for w in (way, points.view))
        above = np.einsum("ij,ij->i", points.geometric, way) > 0
        lit = (wi[:, 2] > 0) & (wo[:, 2] > 0) & above
        if shadows:
            lit[lit] = ~_hidden(scene, points.take(np.flatnonzero(lit)), way[lit], distance[lit])
        gain = np.array(light.intensity) * (wi[:, 2] / distance**2)[:, None]
        for m, material in enumerate(scene.materials):
            here = np.flatnonzero(lit & (points.material == m))
            if len(here):
                out[here] += source_of(material).evaluate(wi[here], wo[here]) * gain[here]
    return out


def _hidden(
    scene: Scene, points: Points, way: NDArray[np.float64], distance: NDArray[np.float64]
) -> NDArray[np.bool_]:
    start = points.position + scene.rays.epsilon * points.geometric
    return scene.rays.occluded(
        np.ascontiguousarray(start, np.float32),
        np.ascontiguousarray(way, np.float32),
        (distance - scene.rays.epsilon).astype(np.float32),
    )


def _seen(scene: Scene, dx: float, dy: float) -> tuple[Points, Hits]:
    """What rays meet through a place of every pixel."""
    camera = scene.camera
    y, x = np.mgrid[0 : camera.height, 0 : camera.width].reshape(2, -1).astype(np.float64)
    directions = camera.directions(x + dx, y + dy)
    origins = np.tile(np.array(camera.position, np.float32), (len(directions), 1))
    hits, points = scene.rays.intersect(origins, directions), no_points(len(directions))
    points.view[:] = -directions
    describe(scene.geometry, scene.material_table, hits.triangle, hits.b1, hits.b2, points)
    return points, hits


def _local(points: Points, w: NDArray[np.floating]) -> NDArray[np.float64]:
    """(n, 3): directions in the frames of the points, with x along the grain if there is one."""
    out = np.zeros((len(w), 3))
    args = (points.normal, points.row, np.ascontiguousarray(w, np.float64), out)
    for_ranges(_to_local, len(w), *args)
    return out


@njit(cache=True, nogil=True)
def _to_local(start, stop, normal, row, w, out):
    for i in range(start, stop):
        n = vec(normal, i)
        s, t = tangents(n)
        local = to_local(vec(w, i), s, t, n)
        if row[i, GRAIN] != 0.0 or row[i, GRAIN + 1] != 0.0:
            local = to_grain(row[i], local)
        out[i, 0], out[i, 1], out[i, 2] = local
