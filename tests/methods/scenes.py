"""Small scenes that the tests of methods share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from engine.scene.build import build
from engine.scene.camera import Camera
from engine.scene.edits import edited_camera
from engine.scene.open import describe, open_scene
from engine.scene.scene import Scene

POINT: dict[str, Any] = {
    "id": "point",
    "type": "point",
    "position": [0.2, 0.4, 0.1],
    "intensity": [1.0, 0.8, 0.6],
}


def scene(**document: Any) -> Scene:
    """A scene of its description; without `environment` and `lights` there is none."""
    return build(describe({"lights": [], **document}), Path())


def camera(size: int = 32, **fields: Any) -> dict[str, Any]:
    """A square picture from (0, 0, 0.9) along -z, where `fields` do not say otherwise."""
    return {
        "position": [0, 0, 0.9],
        "target": [0, 0, 0],
        "fov_y_degrees": 70,
        "width": size,
        "height": size,
        **fields,
    }


def white_room(albedo: float, lights: list[dict[str, Any]], size: int = 32) -> Scene:
    """A closed cube of side 2 of one albedo, seen from inside, a little off its axes."""
    return scene(
        camera=camera(size, position=[0.07, 0.04, 0.9], target=[-0.03, 0.01, 0]),
        lights=lights,
        materials={"wall": {"type": "diffuse", "diffuse": [albedo] * 3}},
        objects=[
            {"name": "box", "mesh": {"shape": "box", "size": [2, 2, 2]}, "material": "wall"},
        ],
    )


def cornell(size: int = 48) -> Scene:
    """The Cornell box in a small picture."""
    box = open_scene("cornell-box")
    return box.with_camera(edited_camera(box.camera, {"width": size, "height": size}))


def with_camera(scene: Scene, **fields: Any) -> Scene:
    """The scene through a camera of which some fields differ."""
    return scene.with_camera(Camera.model_validate({**scene.camera.model_dump(), **fields}))


def rectangle(name: str, size: Any, translate: Any, rotate: Any = (0, 0, 0)) -> dict[str, Any]:
    """An object: a rectangle that faces +z before it is turned."""
    return {
        "name": name,
        "mesh": {"shape": "rectangle", "size": size},
        "transform": {"translate": translate, "rotate_degrees": rotate},
    }
