"""Edits that no precompute has seen: the same seed draws the same ones.

Those of lights take turns: a sharp spot on something that the camera sees (the hard case of
`direct_to_indirect` §3.7), a bare point light, and one of the scene's own lights moved while the
others stay. All keep off the surfaces: a light close to a wall is a case of its own, in which noise
and the 1/r² of a point drown everything else.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.errors import SceneError
from engine.light.base import Light
from engine.light.point import PointLight
from engine.measure.material_edits import dragged
from engine.scene.edits import Edits
from engine.scene.scene import Scene

CONE_DEGREES, PENUMBRA_DEGREES = 20.0, 2.0
TRIES = 1000
TURN = 0.3
CLEARANCE, FEELERS = 0.03, 128  # of the scene's size; rays that feel for surfaces
Position = tuple[float, float, float]


def held_out_edits(scene: Scene, count: int, seed: int) -> list[Edits]:
    """`count` light edits; raises SceneError where the camera sees nothing."""
    rng = np.random.default_rng(seed)
    movable = [light for light in scene.lights if light.enabled and _has_position(light)]
    off = [{"id": light.id, "enabled": False} for light in scene.lights]
    edits = []
    for k in range(count):
        light = movable[k // 3 % len(movable)] if k % 3 == 2 and movable else None
        target, position = _seen_point(scene, rng, _radius(light))
        if light is not None:
            edits.append(Edits(lights=[{"id": light.id, "position": position}]))
        elif k % 3 == 1:
            edits.append(Edits(lights=[*off, _probe(scene, "point", position)]))
        else:
            aim = {
                "target": target,
                "cone_degrees": CONE_DEGREES,
                "penumbra_degrees": PENUMBRA_DEGREES,
            }
            edits.append(Edits(lights=[*off, {**_probe(scene, "spot", position), **aim}]))
    return edits


def held_out_turns(scene: Scene, count: int, seed: int) -> list[Edits]:
    """`count` turns of the scene's environment; raises SceneError where it has none."""
    if scene.environment is None:
        raise SceneError("the scene has no environment that could be turned", field="environment")
    angles = np.random.default_rng(seed).uniform(-180, 180, count)
    return [Edits(environment={"rotation_degrees": round(float(angle), 2)}) for angle in angles]


def held_out_views(scene: Scene, count: int, seed: int) -> list[Edits]:
    """`count` places of the camera round its target, as far off and as high as it is."""
    target = np.array(scene.camera.target)
    x, y, z = np.array(scene.camera.position) - target
    edits = []
    for angle in np.random.default_rng(seed).uniform(-np.pi, np.pi, count):
        c, s = np.cos(angle), np.sin(angle)
        place = target + np.array([c * x + s * z, y, c * z - s * x])
        edits.append(Edits(camera={"position": _rounded(place)}))
    return edits


def many_lights(scene: Scene, count: int, seed: int) -> tuple[PointLight, ...]:
    """`count` white point lights in the open, in all as bright as one probe."""
    rng = np.random.default_rng(seed)
    intensity = _probe_intensity(scene) / count
    return tuple(
        PointLight(
            id=f"light {k}", position=_seen_point(scene, rng, 0.0)[1], intensity=(intensity,) * 3
        )
        for k in range(count)
    )


def nudged(edits: Edits, step: float) -> Edits:
    """The same edits moved on by a little.

    Every light that has a position, and the camera, by `step` metres along x; a turned environment
    by TURN degrees for every thousandth of that; a material's colour as far as a number.
    """
    if edits.environment is not None and "rotation_degrees" in edits.environment:
        angle = edits.environment["rotation_degrees"] + TURN * step * 1000
        return edits.model_copy(
            update={"environment": {**edits.environment, "rotation_degrees": angle}}
        )
    if edits.materials is not None:
        return edits.model_copy(
            update={"materials": {m: dragged(c, step) for m, c in edits.materials.items()}}
        )
    if edits.camera is not None:
        x, y, z = edits.camera["position"]
        return edits.model_copy(update={"camera": {"position": (x + step, y, z)}})
    lights = [dict(light) for light in edits.lights or []]
    for light in lights:
        if light.get("position") is not None:
            x, y, z = light["position"]
            light["position"] = (x + step, y, z)
    return edits.model_copy(update={"lights": lights})


def _has_position(light: Light) -> bool:
    return "position" in type(light).model_fields


def _probe(scene: Scene, kind: str, position: Position) -> dict[str, Any]:
    """A white light that gives an irradiance of about 1 across the scene."""
    intensity = _probe_intensity(scene)
    return {"id": "probe", "type": kind, "position": position, "intensity": (intensity,) * 3}


def _probe_intensity(scene: Scene) -> float:
    return (scene.diagonal / 2) ** 2


def _radius(light: Light | None) -> float:
    """How far the light reaches from its position, metres."""
    width, height = getattr(light, "width", 0.0), getattr(light, "height", 0.0)
    return max(float(np.hypot(width, height)) / 2, getattr(light, "radius", 0.0))


def _seen_point(scene: Scene, rng: np.random.Generator, radius: float) -> tuple[Position, Position]:
    """(a point that the camera sees, a place in the open from which it can be lit).

    Nothing is nearer to the place than CLEARANCE and the light's own radius. It lies between a
    visible point and what another ray from there meets, so it is in the same room.
    """
    camera = scene.camera
    for _ in range(TRIES):
        x, y = rng.uniform(0, camera.width, 1), rng.uniform(0, camera.height, 1)
        seen = _cast(scene, np.array(camera.position), camera.directions(x, y)[0])
        side = _random_direction(rng)
        share, reach = rng.uniform(0.3, 0.7), scene.diagonal / 2
        if seen is None:
            continue
        point, toward_eye = seen
        if side @ toward_eye < 0:
            side = -side
        other = _cast(scene, point + 4 * scene.rays.epsilon * toward_eye, side)
        if other is not None:
            reach = min(reach, float(np.linalg.norm(other[0] - point)))
        if reach > 0.05 * scene.diagonal:
            place = point + share * reach * side
            if _nearest(scene, place, rng) > CLEARANCE * scene.diagonal + radius:
                return _rounded(point), _rounded(place)
    raise SceneError("the camera sees nothing that could be lit")


def _cast(scene: Scene, origin: NDArray, direction: NDArray) -> tuple[NDArray, NDArray] | None:
    """(point hit, unit normal against the direction), or None."""
    hits = scene.rays.intersect(
        np.ascontiguousarray(origin[None], np.float32),
        np.ascontiguousarray(direction[None], np.float32),
    )
    if hits.triangle[0] < 0:
        return None
    a, b, c = scene.geometry.positions[scene.geometry.triangles[hits.triangle[0]]].astype(float)
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    point = origin + float(hits.distance[0]) * direction.astype(float)
    return point, -normal if normal @ direction > 0 else normal


def _nearest(scene: Scene, place: NDArray, rng: np.random.Generator) -> float:
    """Distance to the nearest surface, as far as some rays can tell."""
    directions = np.array([_random_direction(rng) for _ in range(FEELERS)], np.float32)
    origins = np.tile(np.float32(place), (FEELERS, 1))
    return float(scene.rays.intersect(origins, directions).distance.min())


def _random_direction(rng: np.random.Generator) -> NDArray:
    direction = rng.normal(size=3)
    return direction / np.linalg.norm(direction)


def _rounded(point: NDArray) -> Position:
    x, y, z = (round(float(c), 4) for c in point)
    return x, y, z
