"""What a place of the picture shows, against the picture of all pixels' materials."""

from __future__ import annotations

import numpy as np

from engine.scene.open import open_scene
from engine.scene.pick import material_at


def test_the_nearest_surface_is_picked() -> None:
    """The box's front is open: its walls are seen over its rim, the blocks before the back."""
    scene = open_scene("cornell-box")
    assert material_at(scene, 0.1, 0.5) == "red"
    assert material_at(scene, 0.9, 0.5) == "green"
    assert material_at(scene, 0.5, 0.5) == "tall block"
    assert material_at(scene, 0.001, 0.5) is None


def test_places_run_from_the_upper_left_corner() -> None:
    """Over a picture that is wider than it is high."""
    scene = open_scene("cornell-box")
    camera = scene.camera.model_copy(update={"width": 64, "height": 32})
    wide = scene.with_camera(camera)
    rows, columns = np.mgrid[0:32, 0:64] + 0.5
    hits = scene.rays.intersect(
        np.repeat(np.array([camera.position], np.float32), 64 * 32, axis=0),
        camera.directions(columns.ravel(), rows.ravel()),
    )
    for pixel in range(0, 64 * 32, 7):
        triangle = hits.triangle[pixel]
        shown = scene.material_names[scene.geometry.material[triangle]] if triangle >= 0 else None
        x, y = columns.ravel()[pixel] / 64, rows.ravel()[pixel] / 32
        assert material_at(wide, x, y) == shown
