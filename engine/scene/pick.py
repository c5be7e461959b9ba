"""Which material a place of the picture shows."""

from __future__ import annotations

import numpy as np

from engine.scene.scene import Scene


def material_at(scene: Scene, x: float, y: float) -> str | None:
    """Name of the material at (x, y), None where there is nothing.

    Both run from 0 at the left and top edge of the picture to 1.
    """
    camera = scene.camera
    place = np.array([x * camera.width]), np.array([y * camera.height])
    origin = np.array([camera.position], np.float32)
    triangle = scene.rays.intersect(origin, camera.directions(*place)).triangle[0]
    return None if triangle < 0 else scene.material_names[scene.geometry.material[triangle]]
