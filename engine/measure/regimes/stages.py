"""Small scenes that show one difficulty each: what regimes share. Metres, y up."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.images import write_image
from engine.scene.build import build
from engine.scene.builtin.pieces import matt
from engine.scene.edits import edited_camera
from engine.scene.open import describe, open_scene
from engine.scene.scene import Scene

Described = dict[str, Any]

GREY = matt(0.5, 0.5, 0.5)
POINT: Described = {
    "id": "lamp", "type": "point", "position": [0.2, 0.4, 0.1], "intensity": [1.0, 0.8, 0.6],
}  # fmt: skip
LAMP: Described = {
    "id": "lamp", "type": "area", "position": [0, 0.9, -0.3], "target": [0, -1, -0.3],
    "up": [0, 0, 1], "width": 0.5, "height": 0.5, "intensity": [16] * 3,
}  # fmt: skip

LIT: Described = {**POINT, "position": [0.8, 1, 1.6], "intensity": [4, 3, 2]}  # from aside
BEHIND: Described = {**LAMP, "position": [0, 0.9, 0.75], "target": [0, -1, 0.75]}  # the eye

COARSER: dict[str, Any] = {"light_texels": 32, "visibility_texels": 64}
"""Settings of `glossy_prt` for small pictures."""


def built(folder: Path = Path(), **document: Any) -> Scene:
    """A scene of its description; without `environment` and `lights` there is none."""
    return build(describe({"lights": [], **document}), folder)


def with_picture(
    make: Callable[[Path], Scene], picture: NDArray[np.float32], name: str = "picture.exr"
) -> Scene:
    """make(folder), where the folder has a picture (h, w, 3) of that name."""
    with tempfile.TemporaryDirectory() as folder:
        write_image(Path(folder) / name, picture)
        return make(Path(folder))


def camera(side: int, **fields: Any) -> Described:
    """A square picture, by default from (0, 0, 0.9) along -z."""
    usual = {"position": [0, 0, 0.9], "target": [0, 0, 0], "fov_y_degrees": 70}
    return {**usual, "width": side, "height": side, **fields}


def rectangle(
    name: str, material: str, size: Any, at: Any, turn: Any = (0, 0, 0), segments: Any = (1, 1)
) -> Described:
    """An object: a rectangle that faces +z before it is turned."""
    return {
        "name": name,
        "material": material,
        "mesh": {"shape": "rectangle", "size": size, "segments": list(segments)},
        "transform": {"translate": at, "rotate_degrees": turn},
    }


def sphere(name: str, material: str, radius: float, at: Any, rings: int = 24) -> Described:
    """An object: a ball."""
    return {
        "name": name,
        "material": material,
        "mesh": {"shape": "sphere", "radius": radius, "rings": rings},
        "transform": {"translate": at},
    }


def phong(exponent: float, diffuse: float = 0.2, specular: float = 0.5) -> Described:
    """Phong's material, in greys."""
    return {
        "type": "phong", "diffuse": [diffuse] * 3, "specular": [specular] * 3,
        "exponent": exponent,
    }  # fmt: skip


def blinn(exponent: float, diffuse: float = 0.0) -> Described:
    """Blinn-Phong's, which `brdf_editing` cuts into elements."""
    return {**phong(exponent, diffuse, 0.7), "type": "blinn_phong"}


def metal(roughness: float, reflectance: float = 0.9) -> Described:
    """Bare metal."""
    return {
        "type": "ggx", "diffuse": [0] * 3, "specular": [reflectance] * 3, "roughness": roughness,
    }  # fmt: skip


def cornell(side: int) -> Scene:
    """The Cornell box in a small picture."""
    box = open_scene("cornell-box")
    return box.with_camera(edited_camera(box.camera, {"width": side, "height": side}))


def room(
    side: int, *things: Described, wall: Described = GREY, thing: Described = GREY,
    lights: Any = (POINT,), **looks: Any,
) -> Scene:  # fmt: skip
    """A closed cube of side 2 with things in it, seen from inside, a little off its axes."""
    usual = {"position": [0.07, 0.04, 0.9], "target": [-0.03, 0.01, 0]}
    return built(
        camera=camera(side, **{**usual, **looks}),
        lights=list(lights),
        materials={"wall": wall, "thing": thing},
        objects=[
            {"name": "room", "mesh": {"shape": "box", "size": [2, 2, 2]}, "material": "wall"},
            *things,
        ],
    )


def hall(side: int, floor: Described, back: Described, lights: Any, **fields: Any) -> Scene:
    """A floor, a wall behind it, and a matt ceiling."""
    return built(
        camera=camera(side, position=[0, 0.3, 2.4], target=[0, -0.55, 0], fov_y_degrees=42),
        lights=list(lights),
        materials={"floor": floor, "back": back, "grey": matt(0.6, 0.6, 0.6)},
        objects=[
            rectangle("floor", "floor", [2, 3], [0, -1, 0.5], [-90, 0, 0]),
            rectangle("back", "back", [2, 2], [0, 0, -1]),
            rectangle("ceiling", "grey", [2, 3], [0, 1, 0.5], [90, 0, 0]),
        ],
        **fields,
    )


def floor_alone(side: int, material: Described, **fields: Any) -> Scene:
    """A floor that fills the picture, and nothing else."""
    return built(
        camera=camera(side, position=[0, 0.6, 1.2], target=[0, -1, 0.15], fov_y_degrees=20),
        materials={"floor": material},
        objects=[rectangle("floor", "floor", [4, 4], [0, -1, 0.5], [-90, 0, 0])],
        **fields,
    )


def ball_alone(side: int, material: Described, folder: Path = Path(), **fields: Any) -> Scene:
    """A ball that fills most of the picture, and nothing else."""
    return built(
        folder,
        **{
            "camera": camera(side, position=[0, 0.4, 2], fov_y_degrees=34),
            "materials": {"ball": material},
            "objects": [sphere("ball", "ball", 0.5, [0, 0, 0], 48)],
            **fields,
        },
    )


def ball_on_floor(
    side: int, ball: Described, floor: Described, cuts: int = 48, folder: Path = Path(),
    **fields: Any,
) -> Scene:  # fmt: skip
    """A ball just over a floor that is cut so often along a side."""
    return built(
        folder,
        camera=camera(side, position=[0, 2, 3], target=[0, -0.4, 0], fov_y_degrees=40),
        materials={"ball": ball, "floor": floor},
        objects=[
            sphere("ball", "ball", 0.5, [0, 0, 0]),
            rectangle("floor", "floor", [3, 3], [0, -0.52, 0], [-90, 0, 0], (cuts, cuts)),
        ],
        **fields,
    )


def of(make: Callable[..., Scene], *arguments: Any, **fields: Any) -> Callable[[int], Scene]:
    """side -> make(side, *arguments, **fields)."""
    return lambda side: make(side, *arguments, **fields)
