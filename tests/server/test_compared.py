"""A frame beside its reference where there is nothing to see."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from httpx import Client

from engine.measure.truth import truth
from engine.scene.edits import Edits
from engine.scene.open import open_scene
from engine.store import Store
from server.compared import MOST_PIXELS, Compared
from server.precompute import Task


def test_a_black_reference_has_no_relative_error(tiny_scene: Path) -> None:
    scene = open_scene(tiny_scene)
    edits = Edits(lights=[{"id": light.id, "enabled": False} for light in scene.lights])
    found = truth(scene, edits, 0.1, Store(), max_seconds=5)
    task = Task(
        scene="tiny-box", source=str(tiny_scene), camera=scene.camera, method="direct_to_indirect",
        work="reference", edits=edits, error=0.1, seconds=5,
    )  # fmt: skip
    compared = Compared(scene, task, found.image, "direct")
    off = compared.result(0.0).verdict
    assert (off.error, off.least, off.psnr) == (0.0, None, None)
    assert np.ptp(compared.picture("difference", 0.0)) == 0
    assert Compared(scene, task, found.image + 1, "direct").result(0.0).verdict.error is None


def test_a_reference_has_only_so_many_pixels(client: Client) -> None:
    edits = {"camera": {"width": MOST_PIXELS // 1024 + 1, "height": 1024}}
    answer = client.post("/api/scenes/tiny-box/reference", json=edits)
    assert (answer.status_code, answer.json()["field"]) == (422, "camera")
