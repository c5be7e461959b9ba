"""What a camera sees of a mesh, and its colour from the light-dependent vectors of the corners."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light.environment import Environment
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.methods.glossy_prt.vertices import Vertices
from engine.methods.glossy_prt.views import Maps, corner_views, first_row
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import add, dot, mul, scale, sub, vec
from engine.scene import surface
from engine.scene.camera import Camera
from engine.scene.scene import Scene

SUBSAMPLES = np.array([[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]])
SAME_NORMAL, SAME_DEPTH = 0.9, 0.02


class Seen(NamedTuple):
    """What m rays from the eye meet.

    triangle  (m,) int32       -1 where nothing
    b1, b2    (m,) float32     barycentrics of its second and third corner
    away      (m, 3) float32   unit, from the eye
    """

    triangle: NDArray[np.int32]
    b1: NDArray[np.float32]
    b2: NDArray[np.float32]
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
    x, y = np.arange(0, camera.width, step) + 0.5, np.arange(0, camera.height, step) + 0.5
    shape = (len(y), len(x))
    x, y = np.tile(x, len(y)), np.repeat(y, len(x))
    centre = _see(scene, camera, x, y)
    if step > 1:
        return View(shape, centre, np.zeros(0, np.int32), _see(scene, camera, x[:0], y[:0]))
    edge = np.zeros(len(x), np.bool_)
    _find_edges(scene.geometry, centre, np.asarray(camera.position), shape[1], edge)
    pixel = np.flatnonzero(edge).astype(np.int32)
    sx, sy = ((a[pixel, None] + SUBSAMPLES[:, axis]).ravel() for axis, a in enumerate((x, y)))
    return View(shape, centre, pixel, _see(scene, camera, sx, sy))


def _see(scene: Scene, camera: Camera, x: NDArray[Any], y: NDArray[Any]) -> Seen:
    away = camera.directions(x, y)
    eye = np.tile(np.array(camera.position, np.float32), (len(away), 1))
    hits = scene.rays.intersect(eye, away)
    return Seen(hits.triangle, hits.b1, hits.b2, away)


@njit(cache=True, nogil=True)
def _find_edges(geometry, seen, eye, width, edge):
    """Mark pixels beside which another object, material, normal or depth is seen."""
    height = edge.shape[0] // width
    e = (eye[0], eye[1], eye[2])
    for y in range(height):
        for x in range(width):
            i = y * width + x
            for j in (i + 1 if x + 1 < width else i, i + width if y + 1 < height else i):
                if j != i and _apart(geometry, seen, e, i, j):
                    edge[i] = edge[j] = True


@njit(nogil=True)
def _apart(geometry, seen, eye, i, j):
    a, b = seen.triangle[i], seen.triangle[j]
    if a == b:
        return False
    if a < 0 or b < 0 or geometry.material[a] != geometry.material[b]:
        return True
    if geometry.object[a] != geometry.object[b]:
        return True
    na, nb = surface.geometric_normal(geometry, a), surface.geometric_normal(geometry, b)
    if dot(na, nb) < SAME_NORMAL:
        return True
    p = surface.position(geometry, a, seen.b1[i], seen.b2[i])
    q = surface.position(geometry, b, seen.b1[j], seen.b2[j])
    far = sub(p, eye)
    off = min(abs(dot(sub(q, p), na)), abs(dot(sub(q, p), nb)))
    return off * off > SAME_DEPTH * SAME_DEPTH * dot(far, far)


def shade(
    scene: Scene,
    vertices: Vertices,
    maps: Maps,
    lit: NDArray[np.float32],
    seen: Seen,
    environment: Environment | None,
) -> NDArray[np.float32]:
    """(m, 3) float32: radiance that comes along the rays.

    lit (rows, 3) float32 holds the light-dependent vectors, term by term of every vertex.
    """
    out = np.zeros((len(seen.triangle), 3), np.float32)
    for_ranges(
        _shade, len(out), scene.geometry, scene.material_table, vertices, maps, lit,
        int(maps.terms.max()), seen, out, grain=2048,
    )  # fmt: skip
    if environment is not None:
        beyond = np.flatnonzero(seen.triangle < 0)
        out[beyond] = seen_radiance(environment, places_on_map(seen.away[beyond]))
    return out


@njit(cache=True, nogil=True)
def _shade(start, stop, geometry, materials, vertices, maps, lit, most, seen, out):
    geometry, materials, maps = borrow(geometry), borrow(materials), borrow(maps)
    vertices, seen = borrow(vertices), borrow(seen)
    row, h = np.zeros(materials.row.shape[1], np.float32), np.zeros((3, most, 3), np.float32)
    for i in range(start, stop):
        t = seen.triangle[i]
        if t < 0:
            continue
        w = scale(vec(seen.away, i), -1.0)
        terms = corner_views(
            geometry, materials, vertices, maps, t, seen.b1[i], seen.b2[i], w, row, h
        )
        total = (0.0, 0.0, 0.0)
        for corner in range(3):
            first = first_row(maps, vertices, geometry.material[t], vertices.corners[t, corner])
            for k in range(terms):
                total = add(total, mul(vec(h[corner], k), vec(lit, first + k)))
        for c in range(3):
            out[i, c] = max(0.0, total[c]) + materials.emission[geometry.material[t], c]
