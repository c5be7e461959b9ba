"""What a camera sees of a mesh, and its colour from the light-dependent vectors of the corners."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.backend.cpu.raster import on_triangle, visible_triangles
from engine.light.environment import Environment
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.methods.glossy_prt.vertices import Vertices
from engine.methods.glossy_prt.views import Maps, corner_views, first_row
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import normalize, scale, vec
from engine.scene.camera import SUBSAMPLES, Camera
from engine.scene.scene import Scene

STEP = 0.02  # from a pixel to the next, of their distance: what is farther behind is an edge
NEAR = 1e-3  # of the scene's size: where surfaces come nearer, rays are cast


class Seen(NamedTuple):
    """What m rays from the eye meet.

    triangle  (m,) int32       -1 where nothing
    b1, b2    (m,) float32     barycentrics of its second and third corner
    distance  (m,) float32     metres; infinity where nothing
    away      (m, 3) float32   unit, from the eye
    beyond    (b,) int64       rays that meet nothing
    places    (b, 2) float32   where on an environment's map those lead, see `places_on_map`
    """

    triangle: NDArray[np.int32]
    b1: NDArray[np.float32]
    b2: NDArray[np.float32]
    distance: NDArray[np.float32]
    away: NDArray[np.float32]
    beyond: NDArray[np.int64]
    places: NDArray[np.float32]


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
    beyond = _beyond(hits.triangle, away)
    return Seen(hits.triangle, hits.b1, hits.b2, hits.distance, away, *beyond)


def _beyond(
    triangle: NDArray[np.int32], away: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    beyond = np.flatnonzero(triangle < 0)
    return beyond, places_on_map(away[beyond])


def _rasterise(scene: Scene, camera: Camera, step: int, shape: tuple[int, int]) -> Seen | None:
    """What rays through all pixels' centres meet; None where something is too near for that."""
    geometry, eye, to_pixels = scene.geometry, np.array(camera.position), camera.to_pixels(step)
    found = visible_triangles(
        geometry.positions, geometry.triangles, eye, to_pixels, NEAR * scene.diagonal, shape
    )
    if found is None:
        return None
    n = len(found)
    b1, b2, distance = np.zeros((3, n), np.float32)
    away = np.zeros((n, 3), np.float32)
    from_pixels = np.linalg.inv(to_pixels)
    for_ranges(
        _meet, n, geometry.positions, geometry.triangles, eye, from_pixels, shape[1], found,
        b1, b2, distance, away,
    )  # fmt: skip
    return Seen(found, b1, b2, distance, away, *_beyond(found, away))


@njit(cache=True, nogil=True)
def _meet(
    start, stop, positions, triangles, eye, from_pixels, width, triangle, b1, b2, distance, away
):
    """Fill in where the rays through pixels meet the triangles that they show."""
    e, m = (eye[0], eye[1], eye[2]), from_pixels
    for i in range(start, stop):
        x, y = float(i % width), float(i // width)
        w = normalize((
            m[0, 0] * x + m[0, 1] * y + m[0, 2],
            m[1, 0] * x + m[1, 1] * y + m[1, 2],
            m[2, 0] * x + m[2, 1] * y + m[2, 2],
        ))  # fmt: skip
        for axis in range(3):
            away[i, axis] = w[axis]
        distance[i] = np.inf
        if triangle[i] >= 0:
            u, v, far = on_triangle(positions, triangles, triangle[i], e, w)
            b1[i], b2[i], distance[i] = u, v, far


@njit(cache=True, nogil=True)
def _find_edges(start, stop, geometry, seen, width, edge):
    """Mark pixels beside which another object or material is seen, or something farther off."""
    geometry, seen = borrow(geometry), borrow(seen)
    n = edge.shape[0]
    for i in range(start, stop):
        x = i % width
        for j in (
            i - 1 if x > 0 else i,
            i + 1 if x + 1 < width else i,
            i - width if i >= width else i,
            i + width if i + width < n else i,
        ):
            a, b = seen.triangle[i], seen.triangle[j]
            if a == b:
                continue
            if a < 0 or b < 0:
                edge[i] = True
                break
            near, far = seen.distance[i], seen.distance[j]
            if (
                geometry.material[a] != geometry.material[b]
                or geometry.object[a] != geometry.object[b]
                or abs(near - far) > STEP * min(near, far)
            ):
                edge[i] = True
                break


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
        out[seen.beyond] = seen_radiance(environment, seen.places)
    return out


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _shade(start, stop, geometry, materials, vertices, maps, lit, most, seen, out):
    geometry, materials, maps = borrow(geometry), borrow(materials), borrow(maps)
    vertices, seen, flat = borrow(vertices), borrow(seen), borrow(lit.reshape(-1))
    row, h = np.zeros(materials.row.shape[1], np.float32), np.zeros((3, 3 * most), np.float32)
    total = np.zeros(3 * most, np.float32)
    for i in range(start, stop):
        t = seen.triangle[i]
        if t < 0:
            continue
        m, w = geometry.material[t], scale(vec(seen.away, i), -1.0)
        wide = 3 * corner_views(
            geometry, materials, vertices, maps, t, seen.b1[i], seen.b2[i], w, row, h
        )
        for q in range(wide):
            total[q] = 0
        for corner in range(3):
            first = 3 * first_row(maps, vertices, m, vertices.corners[t, corner])
            g, f = flat[first : first + wide], h[corner]
            for q in range(wide):
                total[q] += f[q] * g[q]
        for c in range(3):
            light = np.float32(0)
            for q in range(c, wide, 3):
                light += total[q]
            out[i, c] = max(np.float32(0), light) + materials.emission[m, c]
