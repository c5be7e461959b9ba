"""Edits: partial, checked, and sharing what they do not touch."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.errors import EditError
from engine.images import write_image
from engine.scene.edits import Edits, apply, parse
from engine.scene.open import open_scene
from engine.scene.scene import Scene


@pytest.fixture(scope="module")
def scene() -> Scene:
    opened = open_scene("cornell-box")
    assert opened.rays is not None
    return opened


def test_no_edit_is_the_scene_itself(scene: Scene) -> None:
    assert apply(scene, Edits()) is scene


def test_lights_change_by_id_and_new_ones_come_last(scene: Scene) -> None:
    changes = [
        {"id": "key", "intensity": [9, 8, 7]},
        {"id": "new", "type": "point", "position": [0.1, 0.2, 0.3]},
        {"id": "ceiling", "enabled": False},
    ]
    edited = apply(scene, Edits(lights=changes))
    assert [light.id for light in edited.lights] == ["ceiling", "key", "new"]
    assert edited.lights[1].intensity == (9, 8, 7)
    assert edited.lights[1].row()[:6] == pytest.approx(scene.lights[1].row()[:6])
    assert not edited.lights[0].enabled
    assert edited.geometry is scene.geometry
    assert edited.rays is scene.rays
    assert edited.material_table is scene.material_table
    assert edited.transport_digest == scene.transport_digest


def test_camera_changes_in_part(scene: Scene) -> None:
    edited = apply(scene, Edits(camera={"fov_y_degrees": 20}))
    assert edited.camera.fov_y_degrees == 20
    assert edited.camera.position == scene.camera.position
    assert edited.rays is scene.rays


def test_materials_change_in_part_or_in_type(scene: Scene) -> None:
    before = scene.transport_digest
    edited = apply(
        scene, Edits(materials={"red": {"diffuse": [0, 0, 1]}, "white": {"type": "ggx"}})
    )
    red, white = (edited.material_names.index(name) for name in ("red", "white"))
    assert edited.materials[red] == Diffuse(emission=(0, 0, 0), diffuse=(0, 0, 1))
    assert edited.materials[white] == Ggx(emission=(0, 0, 0))
    assert edited.material_table.row[red, :3].tolist() == [0, 0, 1]
    assert edited.material_table.model[white] != scene.material_table.model[white]
    assert edited.material_table.texels is scene.material_table.texels
    assert edited.geometry is scene.geometry
    assert edited.rays is scene.rays
    # What was precomputed for the old materials must not be taken for the new ones.
    assert edited.transport_digest != before
    assert scene.transport_digest == before


def test_a_material_that_reflects_too_much_is_said_once(scene: Scene) -> None:
    bright = {"type": "phong", "diffuse": [0.9] * 3, "specular": [0.9] * 3, "exponent": 5}
    edited = apply(scene, Edits(materials={"white": bright}))
    assert [d.code for d in edited.diagnoses] == ["albedo_above_one"]
    again = apply(edited, Edits(materials={"white": {"exponent": 6}}))
    assert [d.code for d in again.diagnoses] == ["albedo_above_one"]
    mended = apply(again, Edits(materials={"white": {"specular": [0, 0, 0]}}))
    assert mended.diagnoses == ()


def test_environment_comes_changes_and_keeps_its_map(scene: Scene, tmp_path: Path) -> None:
    lit = apply(scene, Edits(environment={"map": "studio", "intensity": 2}))
    assert lit.environment is not None
    turned = apply(lit, Edits(environment={"rotation_degrees": 90}))
    assert turned.environment is not None
    assert turned.environment.description.intensity == 2
    assert turned.environment.radiance is lit.environment.radiance
    plain = apply(turned, Edits(environment={"map": [1, 2, 3]}))
    assert plain.environment is not None
    assert plain.environment.radiance.ravel().tolist() == [1, 2, 3]


def test_environment_files_lie_beside_the_scene(tmp_path: Path) -> None:
    (tmp_path / "a.json").write_text('{"objects": [{"name": "b", "mesh": {"shape": "box"}}]}')
    write_image(tmp_path / "sky.exr", np.full((4, 8, 3), 0.5, np.float32))
    edited = apply(open_scene(tmp_path / "a.json"), Edits(environment={"map": "sky.exr"}))
    assert edited.environment is not None
    assert edited.environment.radiance.shape == (4, 8, 3)


NAN, INF = float("nan"), float("inf")
BAD: list[tuple[Any, str, str]] = [
    ({"light": []}, "light", "lights"),
    ({"lights": {}}, "lights", "list"),
    ({"lights": [5]}, "lights.0", "object"),
    ([1], "", "object"),
    ({"lights": [{"intensity": [1, 1, 1]}]}, "lights.0.id", "id"),
    ({"lights": [{"id": "key", "intensity": [1, NAN, 1]}]}, "lights.0.intensity.1", "finite"),
    ({"lights": [{"id": "key", "intensity": [INF, 1, 1]}]}, "lights.0.intensity.0", "finite"),
    ({"lights": [{"id": "key", "intensity": [-1, 1, 1]}]}, "lights.0.intensity.0", "-1"),
    ({"lights": [{"id": "key", "intensity": [1, 1]}]}, "lights.0.intensity", "2 entries"),
    ({"lights": [{"id": "key", "intensity": "x"}]}, "lights.0.intensity", "list"),
    ({"lights": [{"id": "key", "intensty": 1}]}, "lights.0.intensty", "intensity"),
    ({"lights": [{"id": "key", "cone_degrees": 200}]}, "lights.0.cone_degrees", "90"),
    ({"lights": [{"id": "key", "enabled": "maybe"}]}, "lights.0.enabled", "true or false"),
    ({"lights": [{"id": "x", "type": "poin"}]}, "lights.0.type", "point"),
    ({"lights": [{"id": "x", "type": "point"}]}, "lights.0.position", "missing"),
    ({"lights": [{"id": "x"}]}, "lights.0.type", "point"),
    ({"lights": [{"id": "y"}, {"id": "key", "position": 1}]}, "lights.0.type", "missing"),
    (
        {"lights": [{"id": f"l{k}", "type": "point", "position": [0, 0, 0]} for k in range(5000)]},
        "lights",
        "5002",
    ),
    ({"materials": {"whit": {}}}, "materials.whit", "white"),
    ({"materials": {"white": 3}}, "materials.white", "object"),
    ({"materials": {"white": {"roughness": 1}}}, "materials.white.roughness", "diffuse"),
    ({"materials": {"white": {"type": "gg"}}}, "materials.white.type", "ggx"),
    ({"materials": {"white": {"diffuse": [2, 0, 0]}}}, "materials.white.diffuse.0", "1"),
    ({"materials": {"white": {"diffuse": {"texture": "a"}}}}, "materials.white.diffuse", "texture"),
    (
        {"materials": {"white": {"type": "measured", "file": "no.csv"}}},
        "materials.white.file",
        "built-in materials are: plastic, brushed, threads",
    ),
    ({"camera": {"fov": 3}}, "camera.fov", "fov_y_degrees"),
    ({"camera": {"position": [NAN, 0, 0]}}, "camera.position.0", "finite"),
    ({"camera": {"target": [0.278, 0.273, -0.8]}}, "camera", "same point"),
    ({"camera": {"width": 16384, "height": 16384}}, "camera", "smaller"),
    ({"camera": {"width": 1.5}}, "camera.width", "whole"),
    ({"environment": {"map": "no.exr"}}, "environment.map", "no such file"),
    ({"environment": {"map": [1, 2]}}, "environment.map", "2 entries"),
    ({"environment": {"intensity": NAN}}, "environment.intensity", "finite"),
]


@pytest.mark.parametrize(("edits", "field", "word"), BAD)
def test_a_bad_edit_names_its_field(scene: Scene, edits: Any, field: str, word: str) -> None:
    with pytest.raises(EditError) as caught:
        apply(scene, parse(edits))
    assert caught.value.field == field
    assert word in caught.value.message
