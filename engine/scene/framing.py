"""Where to put the camera of a scene that comes without one."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.scene.camera import Camera
from engine.scene.rays import RayTracer
from engine.scene.scene import Geometry

FOV_Y_DEGREES, WIDTH, HEIGHT = 40.0, 640, 480
THREE_QUARTER = np.array([0.5, 0.4, 0.8])  # from the object to the camera: above, to the right
ROOM_FOV_Y_DEGREES = 60.0
CLOSED, OPEN = 0.93, 0.6  # parts of the sphere that walls take up
DIRECTIONS = 512
Box = tuple[NDArray[np.float64], NDArray[np.float64]]


def default_camera(geometry: Geometry, rays: RayTracer) -> Camera:
    """A camera that shows an object from outside, a room from inside, a stage from its front.

    An object is seen from above its front, the whole of its bounding sphere in the picture. A room
    is a scene that is closed around its middle by several things that turn their front inwards.
    """
    low, high = _bounds(geometry)
    middle = (low + high) / 2
    directions = _sphere(DIRECTIONS)
    blocked, several = _enclosure(geometry, rays, middle, directions)
    if several and blocked.mean() >= CLOSED:
        camera = _room_camera(geometry, rays)
        if camera is not None:
            return camera
    view = THREE_QUARTER
    if several and OPEN <= blocked.mean() < CLOSED:
        opening = directions[~blocked].astype(np.float64).mean(axis=0)
        # Through the opening of a stage, level unless it opens upwards.
        if np.linalg.norm(opening) > 0.3 and np.linalg.norm(opening[[0, 2]]) > abs(opening[1]):
            view = np.array([opening[0], 0.0, opening[2]])
    return framing_camera(geometry, view)


def framing_camera(geometry: Geometry, view: NDArray[np.float64]) -> Camera:
    """A camera in the direction `view` from the scene, its bounding sphere within the picture."""
    centre, radius = bounding_sphere(geometry)
    distance = 1.02 * radius / math.sin(math.radians(FOV_Y_DEGREES / 2))
    position = centre + distance * view / np.linalg.norm(view)
    return _camera(position, centre, FOV_Y_DEGREES)


def bounding_sphere(geometry: Geometry) -> tuple[NDArray[np.float64], float]:
    """Centre of the bounding box, and the distance of the vertex farthest from it."""
    low, high = _bounds(geometry)
    centre = (low + high) / 2
    used = geometry.positions[geometry.triangles.reshape(-1)]
    return centre, float(np.sqrt(np.max(np.sum((used - centre) ** 2, axis=1))))


def camera_is_inside(geometry: Geometry, rays: RayTracer, camera: Camera) -> bool:
    """Whether walls close the scene around the camera."""
    blocked, several = _enclosure(geometry, rays, np.array(camera.position), _sphere(DIRECTIONS))
    return several and bool(blocked.mean() >= CLOSED)


def headroom(
    geometry: Geometry, rays: RayTracer, place: NDArray[np.float64]
) -> tuple[float, float]:
    """Heights of the floor below and the ceiling above a place; the bounds where there is none."""
    low, high = _bounds(geometry)
    both = np.array([[0, -1, 0], [0, 1, 0]], np.float32)
    hit = rays.intersect(np.tile(place, (2, 1)).astype(np.float32), both)
    floor = place[1] - hit.distance[0] if np.isfinite(hit.distance[0]) else low[1]
    ceiling = place[1] + hit.distance[1] if np.isfinite(hit.distance[1]) else high[1]
    return float(floor), float(ceiling)


def _camera(position: NDArray[np.float64], target: NDArray[np.float64], fov: float) -> Camera:
    return Camera(
        position=tuple(position.tolist()),
        target=tuple(target.tolist()),
        fov_y_degrees=fov,
        width=WIDTH,
        height=HEIGHT,
    )


def _bounds(geometry: Geometry) -> Box:
    used = geometry.positions[geometry.triangles.reshape(-1)].astype(np.float64)
    return used.min(axis=0), used.max(axis=0)


def _sphere(n: int) -> NDArray[np.float32]:
    """(n, 3) float32 unit directions, evenly over the sphere (Fibonacci spiral)."""
    k = np.arange(n) + 0.5
    y = 1 - 2 * k / n
    phi = k * np.pi * (3 - math.sqrt(5))
    r = np.sqrt(1 - y * y)
    return np.stack([r * np.cos(phi), y, r * np.sin(phi)], axis=1).astype(np.float32)


def _enclosure(
    geometry: Geometry, rays: RayTracer, place: NDArray[np.float64], directions: NDArray[np.float32]
) -> tuple[NDArray[np.bool_], bool]:
    """Which directions (n,) end at a surface's front, and whether they end at several things."""
    origins = np.tile(place.astype(np.float32), (len(directions), 1))
    hit = rays.intersect(origins, directions)
    found = hit.triangle >= 0
    blocked = np.zeros(len(directions), bool)
    blocked[found] = _faces(geometry, hit.triangle[found], directions[found])
    ids = hit.triangle[found]
    kinds = {*zip(geometry.object[ids].tolist(), geometry.material[ids].tolist(), strict=True)}
    return blocked, len(kinds) > 1


def _faces(
    geometry: Geometry, triangles: NDArray[np.int32], directions: NDArray[np.float32]
) -> NDArray[np.bool_]:
    """Whether the rays (n,) meet the front of their triangles."""
    corners = geometry.positions[geometry.triangles[triangles]].astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.asarray(np.sum(normal * directions, axis=1) < 0)


def _room_camera(
    geometry: Geometry, rays: RayTracer, grid: int = 12, yaws: int = 12
) -> Camera | None:
    """The place and direction at eye height with the widest and richest view, or None.

    Every place of a grid over the room that has air around it looks in every direction with a
    coarse picture; the best is where much of the picture is far away and many things are seen.
    """
    low, high = _bounds(geometry)
    floor, ceiling = headroom(geometry, rays, (low + high) / 2)
    eye = floor + 0.55 * (ceiling - floor)
    steps = (np.arange(grid) + 0.5) / grid
    x, z = np.meshgrid(low[0] + steps * (high[0] - low[0]), low[2] + steps * (high[2] - low[2]))
    places = np.stack([x.ravel(), np.full(x.size, eye), z.ravel()], axis=1)
    clearance = 0.03 * float(np.linalg.norm(high - low))
    places = places[[_has_air(geometry, rays, place, clearance) for place in places]]
    # Look a little down, as people do; one fan of rays serves all places and directions.
    cameras = [
        _camera(np.zeros(3), np.array([math.sin(yaw), -0.2, math.cos(yaw)]), ROOM_FOV_Y_DEGREES)
        for yaw in 2 * np.pi * np.arange(yaws) / yaws
    ]
    fan = np.concatenate([_coarse_rays(camera) for camera in cameras])
    best, found = 0.0, None
    for place in places:
        scores = _views(geometry, rays, place, fan, yaws)
        if scores.max() > best:
            best = float(scores.max())
            target = place + np.array(cameras[int(np.argmax(scores))].target)
            found = _camera(place, target, ROOM_FOV_Y_DEGREES)
    return found


def _has_air(
    geometry: Geometry, rays: RayTracer, place: NDArray[np.float64], clearance: float
) -> bool:
    """Whether a place is within the walls and that far from everything."""
    directions = _sphere(64)
    origins = np.tile(place.astype(np.float32), (64, 1))
    hit = rays.intersect(origins, directions)
    found = hit.triangle >= 0
    if found.mean() < 0.9 or hit.distance.min() < clearance:
        return False
    return bool(_faces(geometry, hit.triangle[found], directions[found]).mean() > 0.8)


def _coarse_rays(camera: Camera) -> NDArray[np.float32]:
    """(192, 3) directions of a picture of 16 x 12 pixels."""
    y, x = np.mgrid[0:12, 0:16].reshape(2, -1) + 0.5
    return camera.directions(x * WIDTH / 16, y * HEIGHT / 12)


def _views(
    geometry: Geometry,
    rays: RayTracer,
    place: NDArray[np.float64],
    fan: NDArray[np.float32],
    pictures: int,
) -> NDArray[np.float64]:
    """(pictures,) how much there is to see: the depth of a picture times the things in it."""
    hit = rays.intersect(np.tile(place.astype(np.float32), (len(fan), 1)), fan)
    found = hit.triangle >= 0
    front = np.zeros(len(fan), bool)
    front[found] = _faces(geometry, hit.triangle[found], fan[found])
    distance = np.where(found, hit.distance, 0).reshape(pictures, -1)
    things = np.where(found, geometry.material[hit.triangle], -1).reshape(pictures, -1)
    scores = np.median(distance, axis=1) + np.quantile(distance, 0.1, axis=1)
    scores *= [len(np.unique(row[row >= 0])) for row in things]
    scores *= front.reshape(pictures, -1).mean(axis=1)
    return np.where(found.reshape(pictures, -1).mean(axis=1) < 0.9, 0.0, scores)
