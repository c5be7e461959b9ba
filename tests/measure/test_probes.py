"""Held-out edits: reproducible, in the open, of every kind."""

from __future__ import annotations

import numpy as np
import pytest

from engine.errors import SceneError
from engine.measure.probes import held_out_edits
from engine.scene.edits import Edits, edited_lights
from engine.scene.open import open_scene
from engine.scene.scene import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    return open_scene("cornell-box")


def changes(edit: Edits) -> list[dict]:
    assert edit.lights is not None
    return edit.lights


def test_the_seed_decides(scene: Scene) -> None:
    first = held_out_edits(scene, 6, seed=4)
    assert first == held_out_edits(scene, 6, seed=4)
    assert first[:3] == held_out_edits(scene, 3, seed=4)
    assert first != held_out_edits(scene, 6, seed=5)


def test_every_kind_takes_its_turn(scene: Scene) -> None:
    spot, point, own = (changes(edit) for edit in held_out_edits(scene, 3, seed=1))
    assert (spot[-1]["type"], point[-1]["type"]) == ("spot", "point")
    assert own[0]["id"] in {light.id for light in scene.lights}
    for edit in (spot, point):
        on = [light for light in edited_lights(scene.lights, edit) if light.enabled]
        assert [light.id for light in on] == ["probe"]
    moved = edited_lights(scene.lights, own)
    assert sum(a != b for a, b in zip(moved, scene.lights, strict=True)) == 1


def test_places_are_inside_the_box_and_see_their_targets(scene: Scene) -> None:
    edits = held_out_edits(scene, 30, seed=2)
    low, high = scene.geometry.positions.min(axis=0), scene.geometry.positions.max(axis=0)
    places = np.array([changes(edit)[-1]["position"] for edit in edits])
    assert (places[:, :2] > low[:2]).all()
    assert (places < high).all()
    # The front of the box is open, so places may lie before it, but not far.
    assert (places[:, 2] > -0.5 * scene.diagonal).all()
    for edit in edits[::3]:
        spot = changes(edit)[-1]
        origin = np.float32([spot["position"]])
        direction = np.float32([spot["target"]]) - origin
        assert not scene.rays.occluded(origin, direction, 0.99)[0]


def test_lights_keep_off_the_surfaces(scene: Scene) -> None:
    """Asked of many more rays than the probes ask; a lamp keeps its whole self off."""
    rng = np.random.default_rng(3)
    directions = rng.normal(size=(4096, 3))
    directions = (directions / np.linalg.norm(directions, axis=1, keepdims=True)).astype(np.float32)
    for edit in held_out_edits(scene, 12, seed=1):
        moved = changes(edit)[-1]
        (light,) = (x for x in edited_lights(scene.lights, [moved]) if x.id == moved["id"])
        radius = 0.5 * np.hypot(getattr(light, "width", 0), getattr(light, "height", 0))
        origins = np.tile(np.float32(moved["position"]), (len(directions), 1))
        nearest = scene.rays.intersect(origins, directions).distance.min()
        assert nearest > 0.9 * (0.03 * scene.diagonal + radius)


def test_a_camera_that_sees_nothing_is_said_so(scene: Scene) -> None:
    away = scene.camera.model_copy(update={"target": (0.278, 0.273, -9.0)})
    with pytest.raises(SceneError, match="sees nothing"):
        held_out_edits(scene.with_camera(away), 1, seed=1)
