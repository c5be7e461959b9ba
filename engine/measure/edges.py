"""Where a picture has edges: pixels that hold more than one surface.

Two renderers that filter pixels differently disagree there whatever their light transport does,
so the error of a method is taken without them (`direct_to_indirect` §3.7).
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.ndimage import maximum_filter

from engine.light import table as lights
from engine.light.table import light_table
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec
from engine.scene.camera import SparseCamera
from engine.scene.rays import Hits
from engine.scene.scene import Scene

emitted_by = lights.emitted

NORMAL_DEGREES = 20.0
DEPTH = 0.02  # metres off the tangent plane per metre of distance from the eye


def edge_mask(
    position: NDArray[np.floating],
    normal: NDArray[np.floating],
    surface: NDArray[np.integer],
    eye: tuple[float, float, float],
) -> NDArray[np.bool_]:
    """(h, w) bool: whether the 3x3 pixels around hold another surface, normal or depth.

    position (h, w, 3) world space, normal (h, w, 3) unit length, surface (h, w) an id per object
    and material, -1 for the background, where position and normal do not matter.
    """
    distance = np.linalg.norm(position - np.asarray(eye), axis=-1)
    edges = np.zeros(surface.shape, np.bool_)
    height, width = surface.shape
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        # Two views of the picture, shifted against each other: every pair of neighbours once.
        here = (slice(0, height - dy), slice(max(0, -dx), width - max(0, dx)))
        there = (slice(dy, height), slice(max(0, dx), width - max(0, -dx)))
        hit = (surface[here] >= 0) & (surface[there] >= 0)
        turned = np.sum(normal[here] * normal[there], axis=-1) < math.cos(
            math.radians(NORMAL_DEGREES)
        )
        step = position[there] - position[here]
        off_plane = np.minimum(
            np.abs(np.sum(step * normal[here], axis=-1)),
            np.abs(np.sum(step * normal[there], axis=-1)),
        )
        apart = off_plane > DEPTH * np.minimum(distance[here], distance[there])
        differs = (surface[here] != surface[there]) | (hit & (turned | apart))
        edges[here] |= differs
        edges[there] |= differs
    return edges


def scene_edges(scene: Scene) -> NDArray[np.bool_]:
    """The edge mask (h, w) of a scene from its camera, by one ray through every pixel's centre."""
    geometry = scene.geometry
    directions, hits = _centre_hits(scene)
    shape = (scene.camera.height, scene.camera.width)

    # What each ray met; the background keeps zeros and the id -1.
    found = hits.triangle >= 0
    triangle = hits.triangle[found]
    corners = geometry.positions[geometry.triangles[triangle]].astype(np.float64)
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    smooth = _shading_normals(scene, triangle, hits.b1[found], hits.b2[found])
    # Towards the eye: a surface has two sides, and a thin one shows either.
    smooth *= np.where(np.sum(flat * directions[found], axis=1) > 0, -1, 1)[:, None]

    position, normal = np.zeros((len(found), 3)), np.zeros((len(found), 3))
    surface = np.full(len(found), -1, np.int64)
    position[found] = scene.camera.position + hits.distance[found, None] * directions[found]
    normal[found] = smooth
    materials = len(scene.material_names)
    surface[found] = geometry.object[triangle].astype(np.int64) * materials
    surface[found] += geometry.material[triangle]
    return edge_mask(
        position.reshape(*shape, 3),
        normal.reshape(*shape, 3),
        surface.reshape(shape),
        scene.camera.position,
    )


def pixels_that_count(scene: Scene) -> NDArray[np.bool_]:
    """(h, w): those that errors are taken over: without edges, and without lamps themselves."""
    camera = scene.camera
    if isinstance(camera, SparseCamera):
        whole = pixels_that_count(scene.with_camera(camera.whole))
        return whole[:: camera.stride, :: camera.stride]
    return ~(scene_edges(scene) | lamps_seen(scene))


def lamps_seen(scene: Scene) -> NDArray[np.bool_]:
    """(h, w): the pixels through which lamps themselves are seen, and those around them.

    A lamp is a hundred times as bright as what it lights. At its outline that is all that two
    renderers differ by; within, it is all that the error would be a part of.
    """
    directions, hits = _centre_hits(scene)
    eye = np.asarray(scene.camera.position, np.float32)
    met = np.zeros(len(directions), np.bool_)
    for light in scene.lights:
        if light.enabled and light.has_extent:
            table = light_table([light])
            args = table.kind[0], table.row[0], eye, directions, hits.distance, met
            for_ranges(_meet_lamp, len(met), *args)
    grown = maximum_filter(met.reshape(scene.camera.height, scene.camera.width), 3)
    return np.asarray(grown, np.bool_)


@njit(cache=True, nogil=True)
def _meet_lamp(start, stop, kind, row, eye, direction, limit, met):
    """Mark the rays that meet a lamp before their limit."""
    e, lamp = vec(eye.reshape(1, 3), 0), borrow(row)
    for i in range(start, stop):
        distance, _, _, _ = emitted_by(kind, lamp, e, vec(direction, i))
        if 0.0 <= distance <= limit[i]:
            met[i] = True


def seen_objects(scene: Scene) -> NDArray[np.int32]:
    """(h, w): index of the object at every pixel's centre, -1 where the environment is seen."""
    triangle = _centre_hits(scene)[1].triangle
    seen = np.where(triangle < 0, -1, scene.geometry.object[np.maximum(triangle, 0)])
    return seen.reshape(scene.camera.height, scene.camera.width).astype(np.int32)


def _centre_hits(scene: Scene) -> tuple[NDArray[np.float32], Hits]:
    """Directions (h w, 3) through the centres of pixels, and what rays along them meet."""
    camera = scene.camera
    y, x = np.mgrid[0 : camera.height, 0 : camera.width].reshape(2, -1) + 0.5
    directions = camera.directions(x, y)
    origins = np.tile(np.array(camera.position, np.float32), (len(directions), 1))
    return directions, scene.rays.intersect(origins, directions)


def _shading_normals(
    scene: Scene, triangle: NDArray, b1: NDArray, b2: NDArray
) -> NDArray[np.float64]:
    """(n, 3) unit shading normals, on the side of the triangle's winding."""
    corners = scene.geometry.normals[scene.geometry.triangles[triangle]].astype(np.float64)
    weights = np.stack([1.0 - b1 - b2, b1, b2], axis=1)
    normal = np.einsum("nk,nkc->nc", weights, corners)
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
