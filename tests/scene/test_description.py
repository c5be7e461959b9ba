"""Descriptions: the schema, and what is said of documents that do not fit it."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.errors import NotFound, SceneError
from engine.scene.builtin import BUILTIN
from engine.scene.description import Object, Transform
from engine.scene.open import describe, open_scene, schema

BOX: dict[str, Any] = {"name": "box", "mesh": {"shape": "box"}}
CAMERA: dict[str, Any] = {"position": [0, 0, 3], "target": [0, 0, 0]}
POINT: dict[str, Any] = {"id": "a", "type": "point", "position": [0, 1, 0]}

# Part of a document, the field that must be named, a word of the sentence.
BAD = [
    ({"cameras": CAMERA}, "cameras", "did you mean camera"),
    ({"camera": {**CAMERA, "fov": 40}}, "camera.fov", "fov_y_degrees"),
    ({"camera": {"position": [0, 0, 3]}}, "camera.target", "missing"),
    ({"camera": {**CAMERA, "position": [0, 0]}}, "camera.position", "2 entries are too few"),
    ({"camera": {**CAMERA, "target": [0, 0, 3]}}, "camera", "same point"),
    ({"camera": {**CAMERA, "up": [0, 0, 1]}}, "camera", "parallel"),
    ({"camera": {**CAMERA, "width": 0}}, "camera.width", "not 0"),
    ({"camera": {**CAMERA, "width": 16384, "height": 16384}}, "camera", "smaller picture"),
    ({"camera": {**CAMERA, "fov_y_degrees": 180}}, "camera.fov_y_degrees", "less than 170"),
    ({"camera": {**CAMERA, "position": [0, math.nan, 3]}}, "camera.position.1", "finite"),
    ({"camera": 5}, "camera", "object with keys"),
    ({"lights": {}}, "lights", "must be a list"),
    ({"lights": [{**POINT, "intensity": "bright"}]}, "lights.0.intensity", "must be a list"),
    ({"lights": [{**POINT, "intensity": [1, math.inf, 1]}]}, "lights.0.intensity.1", "finite"),
    ({"lights": [{**POINT, "intensity": [1, -1, 1]}]}, "lights.0.intensity.1", "not -1"),
    ({"lights": [{**POINT, "intensty": [1, 1, 1]}]}, "lights.0.intensty", "intensity"),
    ({"lights": [{**POINT, "type": "pont"}]}, "lights.0.type", "point"),
    (
        {"lights": [{"id": "a"}]},
        "lights.0.type",
        "area, disk, distant, point, projector, sphere, spot, sun, uberlight",
    ),
    ({"lights": [POINT, POINT]}, "lights.1.id", "'a'"),
    ({"materials": {"m": {"type": "ggx", "roughnes": 1}}}, "materials.m.roughnes", "roughness"),
    ({"materials": {"m": {"type": "diffuse", "roughness": 1}}}, "materials.m.roughness", "diffuse"),
    ({"materials": {"m": {"type": "gxx"}}}, "materials.m.type", "ggx"),
    ({"materials": {"m": {"type": "diffuse", "diffuse": [2, 0, 0]}}}, "materials.m.diffuse.0", "1"),
    (
        {"materials": {"m": {"type": "diffuse", "diffuse": {"texure": "a.png"}}}},
        "materials.m.diffuse.texture",
        "missing",
    ),
    (
        {"materials": {"m": {"type": "diffuse", "diffuse": {"texture": "no.png"}}}},
        "materials.m.diffuse.texture",
        "no such file",
    ),
    (
        {"materials": {"m": {"type": "measured", "file": "no.brdf"}}},
        "materials.m.file",
        "there is no such file, and built-in materials are: plastic, brushed, threads",
    ),
    ({"materials": {"m": {"type": "measured", "file": ""}}}, "materials.m.file", "at least 1"),
    (
        {"materials": {"m": {"type": "measured", "diffuse": [1, 1, 1]}}},
        "materials.m.diffuse",
        "specular",
    ),
    ({"environment": {"map": "no.exr"}}, "environment.map", "no such file"),
    ({"environment": {"intensity": -1}}, "environment.intensity", "not -1"),
    ({"objects": []}, "objects", "at least 1"),
    ({"objects": [{"name": "a"}]}, "objects.0.mesh", "missing"),
    ({"objects": [BOX, BOX]}, "objects.1.name", "'box'"),
    ({"objects": [{**BOX, "material": "gold"}]}, "objects.0.material", "'gold'"),
    ({"objects": [{**BOX, "mesh": "no.ply"}]}, "objects.0.mesh", "no such file"),
    ({"objects": [{**BOX, "mesh": {"shape": "bx"}}]}, "objects.0.mesh.shape", "box"),
    ({"objects": [{**BOX, "mesh": {"size": [1, 1, 1]}}]}, "objects.0.mesh.shape", "sphere"),
    (
        {"objects": [{**BOX, "mesh": {"shape": "sphere", "radius": 0}}]},
        "objects.0.mesh.radius",
        "0",
    ),
    (
        {"objects": [{**BOX, "mesh": {"shape": "sphere", "raduis": 1}}]},
        "objects.0.mesh.raduis",
        "did you mean radius?",
    ),
    (
        {
            "objects": [
                {
                    **BOX,
                    "mesh": {"shape": "polygons", "polygons": [[[0, 0, 0], [1, 0, 0], [2, 0, 0]]]},
                }
            ]
        },
        "objects.0.mesh",
        "no area",
    ),
    ({"objects": [{**BOX, "transform": {"scale": 0}}]}, "objects.0.transform", "scale of 0"),
    (
        {"objects": [{**BOX, "transform": {"rotate": [0, 0, 0]}}]},
        "objects.0.transform.rotate",
        "rot",
    ),
    ({"objects": [{**BOX, "transform": [[1, 0, 0, 0]] * 4}]}, "objects.0", "0 0 0 1"),
    (
        {
            "objects": [
                {**BOX, "transform": [[0, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]}
            ]
        },
        "objects.0",
        "no inverse",
    ),
    ({"name": ""}, "name", "at least 1"),
]


@pytest.mark.parametrize(("change", "field", "word"), BAD)
def test_a_bad_document_names_field_file_and_remedy(
    write: Callable[..., Path], change: dict[str, Any], field: str, word: str
) -> None:
    path = write(**change)
    with pytest.raises(SceneError) as caught:
        open_scene(path)
    assert caught.value.field == field
    assert word in caught.value.message
    assert caught.value.file


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("", "line 1"),
        ('{"name": "x",\n "objects": [}', "line 2"),
        ("[1, 2]", "object with keys"),
        ("nonsense", "is not JSON"),
        ("\x00\xff", "JSON"),
        ("[" * 100_000, "read"),
    ],
)
def test_a_file_that_is_no_description(tmp_path: Path, text: str, word: str) -> None:
    path = tmp_path / "broken.json"
    path.write_text(text)
    with pytest.raises(SceneError, match=word) as caught:
        open_scene(path)
    assert caught.value.file == "broken.json"


def test_bytes_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "broken.json"
    path.write_bytes(b"\xff\xfe\xfa")
    with pytest.raises(SceneError, match="cannot be read"):
        open_scene(path)


def test_what_is_no_scene_at_all(tmp_path: Path) -> None:
    with pytest.raises(NotFound, match="did you mean cornell-box"):
        open_scene("cornel-box")
    with pytest.raises(SceneError, match="json"):
        open_scene(tmp_path)
    (tmp_path / "a.xyz").write_text("0 0 0")
    with pytest.raises(SceneError, match="glb"):
        open_scene(tmp_path / "a.xyz")


def test_schema_can_be_published_and_knows_every_key() -> None:
    text = json.dumps(schema())
    for word in ("cone_degrees", "rotate_degrees", "texture", "polygons", "blinn_phong", "map"):
        assert f'"{word}"' in text


@pytest.mark.parametrize("name", BUILTIN)
def test_built_in_scenes_are_documents_like_any_other(name: str) -> None:
    document = BUILTIN[name][1]()
    assert describe(json.loads(json.dumps(document))) == describe(document)


def test_rotation_turns_about_x_then_y_then_z_counter_clockwise() -> None:
    quarter = {"x": (90, 0, 0), "y": (0, 90, 0), "z": (0, 0, 90)}
    # Seen from the tip of an axis, the next axis turns onto the one after it.
    for axis, start, end in (("x", 1, 2), ("y", 2, 0), ("z", 0, 1)):
        turned = Transform(rotate_degrees=quarter[axis]).matrix()[:3, :3] @ np.eye(3)[start]
        assert np.allclose(turned, np.eye(3)[end], atol=1e-12)
    angles = (20.0, -50.0, 110.0)
    steps = [Transform(rotate_degrees=tuple(np.eye(3)[k] * angles[k])).matrix() for k in range(3)]
    assert np.allclose(Transform(rotate_degrees=angles).matrix(), steps[2] @ steps[1] @ steps[0])


def test_a_transform_scales_then_rotates_then_translates() -> None:
    transform = Transform(translate=(1, 2, 3), rotate_degrees=(0, 0, 90), scale=(2, 3, 4))
    assert np.allclose(transform.matrix() @ [1, 1, 1, 1], [1 - 3, 2 + 2, 3 + 4, 1])
    thing = Object(name="a", mesh="a.ply", transform=transform.matrix().tolist())
    assert np.allclose(thing.matrix(), transform.matrix())
