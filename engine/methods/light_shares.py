"""How much of a picture comes from where, estimated at a few of its pixels.

It tells a method that leaves out some of the light how much that is, in its scene as it stands.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.environment import environment_on_points
from engine.light.environment import Environment, environment_table
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.surface_points import describe, equivalent_albedo
from engine.methods.fixed_view.view import View
from engine.numerics.frames import tangents
from engine.scene.camera import Camera
from engine.scene.edits import edited_camera
from engine.scene.scene import Scene

Array = NDArray[np.float64]
SIDE = 16  # pixels, of which that many in the middle of each
RAYS = 32  # of a pixel, that look for what shines on it a second time
SAMPLES = 8  # of the environment
LAMPS = 32  # that are looked at, of however many
MOST_KEPT = 0.95  # a room that keeps more than this of its light per bounce is not believed


class Shares(NamedTuple):
    """Norms of parts of a picture by that of the whole, as `relative_l2` counts them.

    lamps        what lamps light at first
    environment  what the environment does
    bounced      what light of lamps does that bounces once and more
    """

    lamps: float
    environment: float
    bounced: float


def light_shares(scene: Scene) -> Shares:
    """Of the scene under its own lights, from its own camera; takes some hundredths of a second."""
    points = _seen(scene, scene.camera)
    if not len(points):
        return Shares(0.0, 0.0, 0.0)
    lamps = _lit(scene, points)
    sky = _under(scene.environment, scene, points)
    bounced = _bounced(scene, points)
    # What shines itself is seen beside what it shines on.
    reflected, shining = lamps + sky + bounced, _shining(scene)
    whole = max(math.hypot(np.linalg.norm(reflected), np.linalg.norm(shining)), 1e-30)
    return Shares(*(float(np.linalg.norm(part)) / whole for part in (lamps, sky, bounced)))


def _shining(scene: Scene) -> NDArray[np.float32]:
    """(SIDE², 3): what the camera sees of lamps, of the environment, and of what glows."""
    view = View(scene.with_camera(edited_camera(scene.camera, {"width": SIDE, "height": SIDE})))
    out = np.zeros((SIDE * SIDE, 3), np.float32)
    view.add_sources(out, scene.lights, 1, scene.environment)
    return out


def _seen(scene: Scene, camera: Camera) -> Points:
    """What SIDE x SIDE pixels show of surfaces."""
    place = (np.arange(SIDE) + 0.5) / SIDE
    y, x = (part.ravel() for part in np.meshgrid(place * camera.height, place * camera.width))
    directions = np.ascontiguousarray(camera.directions(x, y), np.float32)
    origin = np.tile(np.array(camera.position, np.float32), (len(directions), 1))
    return _met(scene, origin, directions)[0]


def _met(
    scene: Scene, origin: NDArray[np.float32], direction: NDArray[np.float32]
) -> tuple[Points, NDArray[np.intp]]:
    """(what rays (n, 3) meet, which of them meet something)."""
    hits = scene.rays.intersect(origin, direction)
    met = np.flatnonzero(hits.triangle >= 0)
    triangle = hits.triangle[met]
    corners = scene.geometry.positions[scene.geometry.triangles[triangle]]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    back = np.einsum("ij,ij->i", normal, direction[met]) > 0
    barycentric = np.stack([hits.b1[met], hits.b2[met]], axis=1)
    return describe(scene, triangle, back, barycentric), met


def _lit(scene: Scene, points: Points) -> Array:
    """(n, 3) radiance that lamps make points reflect."""
    on = [light for light in scene.lights if light.enabled]
    some = on[:: -(-len(on) // LAMPS)] if on else []
    out = np.zeros((len(points), 3))
    for light in some:
        out += light_on_points(scene.rays, points, light)
    return out * (len(on) / max(1, len(some)))


def _under(environment: Environment | None, scene: Scene, points: Points) -> Array:
    """(n, 3) radiance that an environment makes points reflect."""
    return environment_on_points(
        scene.rays, points.position, points.normal, points.geometric, points.view,
        points.model, points.row, environment_table(environment), SAMPLES, 7,
    ).astype(np.float64)  # fmt: skip


def _bounced(scene: Scene, points: Points) -> Array:
    """(n, 3) radiance that points reflect of what lamps make others reflect, and so on."""
    n, rng = len(points), np.random.default_rng(1)
    u, turn = rng.random((2, n, RAYS))
    r, z = np.sqrt(u), np.sqrt(1 - u)
    frame = np.array([tangents(tuple(g)) for g in points.geometric.astype(np.float64)])
    sides = r * np.cos(2 * np.pi * turn), r * np.sin(2 * np.pi * turn)
    way = z[..., None] * points.geometric[:, None, :]
    for k, side in enumerate(sides):
        way = way + side[..., None] * frame[:, k, None, :]
    start = points.position + scene.rays.epsilon * points.geometric
    origin = np.repeat(start, RAYS, axis=0).astype(np.float32)
    others, met = _met(scene, origin, np.ascontiguousarray(way.reshape(-1, 3), np.float32))
    if not len(met):
        return np.zeros((n, 3))
    light = np.zeros((n * RAYS, 3))
    light[met] = _lit(scene, others)
    kept = float(equivalent_albedo(others).mean()) * len(met) / (n * RAYS)
    once = equivalent_albedo(points) * light.reshape(n, RAYS, 3).mean(axis=1)
    return np.asarray(once / (1 - min(MOST_KEPT, kept)))
