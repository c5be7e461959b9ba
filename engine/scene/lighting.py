"""Lights for scenes that come without."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.light.base import Light
from engine.light.point import PointLight
from engine.light.spot import SpotLight
from engine.scene.camera import Camera
from engine.scene.framing import bounding_sphere, camera_is_inside, headroom
from engine.scene.rays import RayTracer
from engine.scene.scene import Geometry


def default_lights(geometry: Geometry, rays: RayTracer, camera: Camera) -> tuple[Light, ...]:
    """Lights that show a scene well: those of a studio around an object, of a room within one.

    Their intensity follows from their distance, so that a white surface they face is about as
    bright as a display's white.
    """
    if camera_is_inside(geometry, rays, camera):
        return _in_a_room(geometry, rays, camera)
    return _around_an_object(geometry, camera)


def _around_an_object(geometry: Geometry, camera: Camera) -> tuple[Light, ...]:
    """A key from above to the left of the camera, a weak fill from the right."""
    centre, radius = bounding_sphere(geometry)
    right, up, back = camera.basis()
    key = centre + radius * (-1.6 * right + 2.2 * up + 1.6 * back)
    fill = centre + radius * (2.4 * right + 0.6 * up + 1.8 * back)
    distance = float(np.linalg.norm(key - centre))
    half = float(np.degrees(np.arcsin(min(1.0, radius / distance))))
    return (
        SpotLight(
            id="key",
            position=_point(key),
            target=_point(centre),
            cone_degrees=min(90.0, half + 12),
            penumbra_degrees=8,
            intensity=_intensity(2.6, distance, (1.0, 0.97, 0.92)),
        ),
        PointLight(
            id="fill",
            position=_point(fill),
            intensity=_intensity(0.6, float(np.linalg.norm(fill - centre)), (0.85, 0.92, 1.0)),
        ),
    )


def _in_a_room(geometry: Geometry, rays: RayTracer, camera: Camera) -> tuple[Light, ...]:
    """A lamp under the middle of the ceiling, and a spot on what the camera looks at."""
    eye = np.array(camera.position)
    ahead = -camera.basis()[2]
    ahead[1] = 0
    ahead /= max(float(np.linalg.norm(ahead)), 1e-9)
    # The middle of what lies ahead, rather than of the bounds, which may hold more than the room.
    hit = rays.intersect(eye[None].astype(np.float32), ahead[None].astype(np.float32))
    reach = float(hit.distance[0])
    if not np.isfinite(reach):
        reach = bounding_sphere(geometry)[1]
    middle = eye + 0.5 * reach * ahead
    floor, ceiling = headroom(geometry, rays, middle)
    height = ceiling - floor
    lamp = np.array([middle[0], floor + 0.68 * height, middle[2]])
    spot = eye + 0.25 * reach * ahead
    spot[1] = floor + 0.85 * height
    aim = eye + 0.6 * reach * ahead
    aim[1] = floor
    throw = float(np.linalg.norm(aim - spot))
    return (
        PointLight(
            id="lamp",
            position=_point(lamp),
            intensity=_intensity(1.0, 0.68 * height, (1.0, 0.93, 0.82)),
        ),
        SpotLight(
            id="key",
            position=_point(spot),
            target=_point(aim),
            cone_degrees=28,
            penumbra_degrees=10,
            intensity=_intensity(1.1, throw, (1.0, 0.97, 0.92)),
        ),
    )


def _point(place: NDArray[np.float64]) -> tuple[float, float, float]:
    return (float(place[0]), float(place[1]), float(place[2]))


def _intensity(
    irradiance: float, distance: float, tint: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Radiant intensity that gives an irradiance at a distance."""
    strength = irradiance * distance * distance
    return (strength * tint[0], strength * tint[1], strength * tint[2])
