"""What a camera that moves freely sees of a mesh."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.backend.cpu.raster import draw
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, scale, vec
from engine.scene import surface
from engine.scene.camera import SUBSAMPLES, Camera
from engine.scene.scene import Scene

STEP = 0.02  # from a pixel to the next, of their distance: what is farther behind is an edge
NEAR = 1e-3  # of the scene's size: where surfaces come nearer, rays are cast


class Seen(NamedTuple):
    """What m rays from the eye meet.

    triangle  (m,) int32       -1 where nothing
    b1, b2    (m,) float32     barycentrics of its second and third corner
    front     (m,) bool        whether its counter-clockwise side is seen
    distance  (m,) float32     metres; infinity where nothing
    away      (m, 3) float32   unit, from the eye
    """

    triangle: NDArray[np.int32]
    b1: NDArray[np.float32]
    b2: NDArray[np.float32]
    front: NDArray[np.bool_]
    distance: NDArray[np.float32]
    away: NDArray[np.float32]


class View(NamedTuple):
    """A camera's pixels: one ray through the centre of each, four through those at edges.

    shape   (height, width)
    centre  height · width rays, row by row from the top
    edge    (m,) int32   pixels that have sub-samples, ascending
    sub     4 m rays
    """

    shape: tuple[int, int]
    centre: Seen
    edge: NDArray[np.int32]
    sub: Seen


def look(scene: Scene, camera: Camera, step: int = 1) -> View:
    """What the camera sees through every step-th pixel of every step-th row."""
    shape = camera.shape(step)
    centre = _rasterise(scene, camera, step, shape) or _cast(scene, camera, *_grid(shape, step))
    edge = np.zeros(len(centre.triangle), np.bool_)
    if step == 1:
        for_ranges(_find_edges, len(edge), scene.geometry, centre, shape[1], edge)
    pixel = np.flatnonzero(edge).astype(np.int32)
    y, x = np.divmod(pixel, shape[1])
    sx, sy = ((a[:, None] + 0.5 + SUBSAMPLES[:, axis]).ravel() for axis, a in enumerate((x, y)))
    return View(shape, centre, pixel, _cast(scene, camera, sx, sy))


def _grid(shape: tuple[int, int], step: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """(x, y) of every pixel's centre."""
    x, y = (step * np.arange(n) + 0.5 for n in shape[::-1])
    return np.tile(x, shape[0]), np.repeat(y, shape[1])


def _cast(scene: Scene, camera: Camera, x: NDArray[Any], y: NDArray[Any]) -> Seen:
    away = camera.directions(x, y)
    eye = np.tile(np.array(camera.position, np.float32), (len(away), 1))
    hits = scene.rays.intersect(eye, away)
    front = np.zeros(len(away), np.bool_)
    for_ranges(_face, len(away), scene.geometry, hits.triangle, away, front)
    return Seen(hits.triangle, hits.b1, hits.b2, front, hits.distance, away)


@njit(cache=True, nogil=True)
def _face(start, stop, geometry, triangle, away, front):
    for i in range(start, stop):
        if triangle[i] >= 0:
            front[i] = surface.shows_front(geometry, triangle[i], scale(vec(away, i), -1.0))


def _rasterise(scene: Scene, camera: Camera, step: int, shape: tuple[int, int]) -> Seen | None:
    """What rays through all pixels' centres meet; None where something is too near for that."""
    geometry, eye, to_pixels = scene.geometry, np.array(camera.position), camera.to_pixels(step)
    drawn = draw(
        geometry.positions, geometry.triangles, eye, to_pixels, NEAR * scene.diagonal, shape
    )
    if drawn is None:
        return None
    distance = np.zeros(len(drawn.triangle), np.float32)
    away = np.zeros((len(distance), 3), np.float32)
    for_ranges(_aim, len(away), np.linalg.inv(to_pixels), shape[1], drawn.inverse, distance, away)
    triangle, b1, b2, _, front = drawn
    return Seen(triangle, b1, b2, front, distance, away)


@njit(cache=True, nogil=True, error_model="numpy")
def _aim(start, stop, from_pixels, width, inverse, distance, away):
    """Fill in where the rays through pixels go, and how far."""
    m = from_pixels
    for i in range(start, stop):
        x, y = float(i % width), float(i // width)
        # One metre deep.
        w = (
            m[0, 0] * x + m[0, 1] * y + m[0, 2],
            m[1, 0] * x + m[1, 1] * y + m[1, 2],
            m[2, 0] * x + m[2, 1] * y + m[2, 2],
        )
        length = math.sqrt(dot(w, w))
        unit = 1.0 / length
        distance[i] = length / inverse[i]
        for axis in range(3):
            away[i, axis] = unit * w[axis]


@njit(cache=True, nogil=True)
def _find_edges(start, stop, geometry, seen, width, edge):
    """Mark pixels beside which another object or material is seen, or something farther off."""
    geometry, seen = borrow(geometry), borrow(seen)
    n = edge.shape[0]
    for i in range(start, stop):
        a = seen.triangle[i]
        # Each pair of neighbours once; threads that meet at a row mark its pixels alike.
        for j in (i + 1 if (i + 1) % width else i, i + width if i + width < n else i):
            b = seen.triangle[j]
            if a == b:
                continue
            if a >= 0 and b >= 0:
                near, far = seen.distance[i], seen.distance[j]
                if (
                    abs(near - far) <= STEP * min(near, far)
                    and geometry.material[a] == geometry.material[b]
                    and geometry.object[a] == geometry.object[b]
                ):
                    continue
            edge[i] = edge[j] = True
