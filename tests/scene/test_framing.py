"""Default cameras and lights: objects whole in the picture, rooms seen from inside."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from engine.light.base import Light
from engine.scene.camera import Camera
from engine.scene.framing import bounding_sphere, camera_is_inside
from engine.scene.open import open_scene
from engine.scene.scene import Scene


def on_screen(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Which points (n, 3) lie in front of the camera and within the picture."""
    right, up, back = camera.basis()
    v = points - np.array(camera.position)
    depth = -v @ back
    half = math.tan(math.radians(camera.fov_y_degrees) / 2)
    x, y = v @ right / depth, v @ up / depth
    inside = (np.abs(y) <= half) & (np.abs(x) <= half * camera.width / camera.height)
    return (depth > 0) & inside


def sphere_points(centre: np.ndarray, radius: float) -> np.ndarray:
    u = np.random.default_rng(1).normal(size=(4000, 3))
    return centre + radius * u / np.linalg.norm(u, axis=1, keepdims=True)


THINGS: list[dict[str, Any]] = [
    {"mesh": {"shape": "box", "size": [1, 1, 1]}},
    {"mesh": {"shape": "box", "size": [10, 0.1, 0.1]}},
    {"mesh": {"shape": "sphere", "radius": 1e-3}, "transform": {"translate": [5, 5, 5]}},
    {"mesh": {"shape": "sphere", "radius": 1e4}},
    {"mesh": {"shape": "rectangle", "size": [1, 3]}},
]


@pytest.mark.parametrize("thing", THINGS, ids=range(len(THINGS)))
def test_the_whole_bounding_sphere_is_in_the_picture(
    described: Callable[..., Scene], thing: dict[str, Any]
) -> None:
    scene = described(objects=[{"name": "thing", **thing}])
    centre, radius = bounding_sphere(scene.geometry)
    assert on_screen(scene.camera, sphere_points(centre, radius)).all()
    # And fills it: a tenth larger would not fit.
    assert not on_screen(scene.camera, sphere_points(centre, 1.1 * radius)).all()
    # From above, and from in front (+z).
    assert scene.camera.position[1] > centre[1]
    assert scene.camera.position[2] > centre[2]


def irradiance(scene: Scene, light: Light, place: np.ndarray) -> float:
    row = light.row()
    distance = np.linalg.norm(row[:3] - place)
    return float(row[6:9].max() / distance**2)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_default_lights_grow_with_the_object(described: Callable[..., Scene], size: float) -> None:
    thing = {"name": "thing", "mesh": {"shape": "sphere", "radius": size}}
    scene = described(objects=[thing])
    assert [light.id for light in scene.lights] == ["key", "fill"]
    assert "default_lights" in [d.code for d in scene.diagnoses]
    centre, radius = bounding_sphere(scene.geometry)
    for light in scene.lights:
        place = np.array(light.row()[:3], float)
        assert np.linalg.norm(place - centre) > 1.5 * radius
        assert 0.3 < irradiance(scene, light, centre) < 4
    key = scene.lights[0]
    assert irradiance(scene, key, centre) > 2 * irradiance(scene, scene.lights[1], centre)


def test_lights_of_the_description_are_left_alone(described: Callable[..., Scene]) -> None:
    assert described(lights=[]).lights == ()
    dark = described(environment={"map": [1, 1, 1]})
    assert dark.lights == ()
    assert dark.environment is not None


def room(folder: Path, walls: int) -> Path:
    """A room of 6 x 3 x 4 metres with a table, as a file of two objects; 5 walls leave out +z."""
    shell = trimesh.creation.box(extents=(6, 3, 4))
    shell.apply_translation([0, 1.5, 0])
    shell.invert()
    if walls == 5:
        shell.update_faces(shell.triangles_center[:, 2] < 1.9)
    table = trimesh.creation.box(extents=(1.2, 0.7, 0.8))
    table.apply_translation([-1, 0.35, -1])
    scene = trimesh.Scene()
    for name, mesh, colour in (("shell", shell, 0.8), ("table", table, 0.3)):
        mesh.visual = trimesh.visual.TextureVisuals(
            uv=np.zeros((len(mesh.vertices), 2)),
            material=trimesh.visual.material.PBRMaterial(
                name=name, baseColorFactor=[colour, colour, colour, 1.0]
            ),
        )
        scene.add_geometry(mesh, geom_name=name)
    scene.export(str(folder / "room.glb"))
    return folder / "room.glb"


def test_a_closed_room_is_seen_from_inside(tmp_path: Path) -> None:
    scene = open_scene(room(tmp_path, walls=6))
    position = np.array(scene.camera.position)
    assert np.all(np.abs(position - [0, 1.5, 0]) < [3, 1.5, 2])
    assert camera_is_inside(scene.geometry, scene.rays, scene.camera)
    # It sees the table, and its lights are in the room too.
    table = scene.geometry.positions[scene.geometry.triangles[scene.geometry.object == 1]]
    assert on_screen(scene.camera, table.reshape(-1, 3)).any()
    for light in scene.lights:
        assert np.all(np.abs(light.row()[:3] - [0, 1.5, 0]) < [3, 1.5, 2])


def test_a_stage_is_seen_through_its_opening(tmp_path: Path) -> None:
    scene = open_scene(room(tmp_path, walls=5))
    position = np.array(scene.camera.position)
    assert position[2] > 2
    assert abs(position[0]) < 0.3 * position[2]
    # The middle of the picture is the back wall, not the outside of anything.
    hit = scene.rays.intersect(
        position[None].astype(np.float32), -scene.camera.basis()[2][None].astype(np.float32)
    )
    assert position[2] - hit.distance[0] == pytest.approx(-2, abs=0.05)


def test_a_solid_object_is_not_taken_for_a_room(tmp_path: Path) -> None:
    ball = trimesh.creation.icosphere(subdivisions=3)
    for inverted in (False, True):
        if inverted:
            ball.invert()
        ball.export(str(tmp_path / "ball.ply"))
        scene = open_scene(tmp_path / "ball.ply")
        assert np.linalg.norm(scene.camera.position) > 2
