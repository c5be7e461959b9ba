"""Small scenes that the tests of methods share."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from engine.scene.build import build
from engine.scene.builtin import knot
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


def small_knot(width: int = 96, height: int = 96, segments: int = 192) -> Scene:
    """The built-in knot of fewer triangles in a small picture."""
    document = knot.document()
    document["camera"] |= {"width": width, "height": height}
    body, floor = document["objects"]
    body["mesh"] |= {"segments": segments, "sides": 16}
    floor["mesh"]["segments"] = [24, 24]
    return build(describe(document), Path())


def hall(lights: list[dict[str, Any]], size: int = 32) -> Scene:
    """A hall of 24 by 24 metres with pillars; the camera sees one corner, with two blocks."""

    def block(name: str, material: str, size: list[float], at: list[float]) -> dict[str, Any]:
        transform = {"translate": [at[0], at[1] + size[1] / 2, at[2]]}
        mesh = {"shape": "box", "size": size}
        return {"name": name, "material": material, "mesh": mesh, "transform": transform}

    shell = {
        "name": "hall",
        "material": "wall",
        "mesh": {"shape": "box", "size": [24, 6, 24]},
        "transform": {"translate": [0, 3, 0]},
    }
    return scene(
        camera=camera(size, position=[-9.6, 1.6, -9.2], target=[-11.6, 0.5, -11.5]),
        lights=lights,
        materials={
            "wall": {"type": "diffuse", "diffuse": [0.7, 0.68, 0.65]},
            "red": {"type": "diffuse", "diffuse": [0.6, 0.15, 0.1]},
            "blue": {"type": "diffuse", "diffuse": [0.15, 0.25, 0.6]},
        },
        objects=[
            shell,
            block("red block", "red", [0.5, 0.8, 0.5], [-11.3, 0, -10.9]),
            block("blue block", "blue", [0.6, 0.4, 0.4], [-10.6, 0, -11.4]),
            *(
                block(f"pillar {x} {z}", "wall", [0.8, 6, 0.8], [x, 0, z])
                for x in (-6, 0, 6)
                for z in (-6, 0, 6)
            ),
        ],
    )
