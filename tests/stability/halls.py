"""Halls, floors and what is said of them: what tests of edited materials share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from methods.scenes import camera, rectangle, scene
from numpy.typing import NDArray

from engine.methods.base import Frame
from engine.methods.brdf_editing import Polynomial
from engine.scene.edits import Edits
from engine.scene.scene import Scene

Editable = Callable[..., Polynomial]
GREY = {"type": "diffuse", "diffuse": [0.6] * 3}
LAMP = {
    "id": "lamp", "type": "area", "position": [0, 0.9, -0.3], "target": [0, -1, -0.3],
    "up": [0, 0, 1], "width": 0.5, "height": 0.5, "intensity": [16] * 3,
}  # fmt: skip


def edit(**materials: Any) -> Edits:
    return Edits(materials=materials)


def said(frame: Frame, code: str) -> float:
    """Size of a warning; 0 where there is none."""
    return next((w.size for w in frame.warnings if w.code == code), 0.0)


def message(frame: Frame, code: str) -> str:
    return next(w.message for w in frame.warnings if w.code == code)


def off(found: NDArray, true: NDArray) -> float:
    return float(np.linalg.norm(found - true) / np.linalg.norm(true))


def smooth(image: NDArray) -> NDArray:
    """Means of 4 x 4 pixels, which hold less of the reference's noise."""
    height, width = image.shape[:2]
    return image.reshape(height // 4, 4, width // 4, 4, 3).mean(axis=(1, 3))


def gloss(exponent: float, diffuse: float = 0.0) -> dict[str, Any]:
    return {
        "type": "blinn_phong", "diffuse": [diffuse] * 3, "specular": [0.7] * 3,
        "exponent": exponent,
    }  # fmt: skip


def metal(roughness: float) -> dict[str, Any]:
    return {"type": "ggx", "diffuse": [0] * 3, "specular": [0.7] * 3, "roughness": roughness}


def floor(material: dict[str, Any], size: int = 32, **fields: Any) -> Scene:
    """A floor alone, all that the picture shows."""
    looks = camera(size, position=[0, 0.6, 1.2], target=[0, -1, 0.15], fov_y_degrees=20)
    return scene(
        camera=looks,
        materials={"floor": material},
        objects=[{**rectangle("floor", [4, 4], [0, -1, 0.5], [-90, 0, 0]), "material": "floor"}],
        **fields,
    )


def hall(ground: dict[str, Any], back: dict[str, Any], lights: list[dict[str, Any]]) -> Scene:
    """A floor, a wall behind it, and a matt ceiling."""
    return scene(
        camera=camera(32, position=[0, 0.3, 2.4], target=[0, -0.55, 0], fov_y_degrees=42),
        lights=lights,
        materials={"floor": ground, "back": back, "grey": GREY},
        objects=[
            {**rectangle("floor", [2, 3], [0, -1, 0.5], [-90, 0, 0]), "material": "floor"},
            {**rectangle("back", [2, 2], [0, 0, -1]), "material": "back"},
            {**rectangle("ceiling", [2, 3], [0, 1, 0.5], [90, 0, 0]), "material": "grey"},
        ],
    )
