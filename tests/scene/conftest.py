"""What the tests of scenes share: small description files, and a look at a scene by one ray."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from engine.brdf.base import ROW
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.scene.surface import normals, parameters


class Look(NamedTuple):
    """What a ray meets: distance, object, material, BRDF parameters there."""

    distance: float
    object: str
    material: str
    row: np.ndarray


@pytest.fixture
def look() -> Callable[[Scene, Any, Any], Look]:
    """look(scene, origin, direction): what the ray meets."""

    def ray(scene: Scene, origin: Any, direction: Any) -> Look:
        hit = scene.rays.intersect(
            np.array([origin], np.float32), np.array([direction], np.float32)
        )
        t = int(hit.triangle[0])
        assert t >= 0, "the ray meets nothing"
        b1, b2 = float(hit.b1[0]), float(hit.b2[0])
        back = tuple(-np.asarray(direction, float))
        row = np.zeros(ROW)
        _, n = normals(scene.geometry, scene.material_table, t, b1, b2, back)
        parameters(scene.geometry, scene.material_table, t, b1, b2, n, row)
        return Look(
            float(hit.distance[0]),
            scene.object_names[scene.geometry.object[t]],
            scene.material_names[scene.geometry.material[t]],
            row,
        )

    return ray


@pytest.fixture
def write(tmp_path: Path) -> Callable[..., Path]:
    """write(objects=..., ...): a description file; one box where no objects are given."""

    def description(**document: Any) -> Path:
        document.setdefault("objects", [{"name": "box", "mesh": {"shape": "box"}}])
        path = tmp_path / "scene.json"
        path.write_text(json.dumps(document))
        return path

    return description


@pytest.fixture
def described(write: Callable[..., Path]) -> Callable[..., Scene]:
    """described(objects=..., ...): the scene of such a description."""
    return lambda **document: open_scene(write(**document))
