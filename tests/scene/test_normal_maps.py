"""Normal maps bend the shading normal the right way, from every format and on every side."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image

from engine.scene.description import NormalMap
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.scene.surface import normals

# Leaning right by 30 degrees and up by 10: right and up of the image, as a person sees it.
LEANING = np.array([np.sin(np.radians(30)), np.sin(np.radians(10)), 0.0])
LEANING[2] = np.sqrt(1 - LEANING @ LEANING)
BYTE = 1 / 255  # what a component may be off by
BENT = "newmtl m\nKd 1 1 1\nnorm bent.png\n"
QUAD = "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n"


def image(folder: Path, normal: np.ndarray = LEANING) -> Path:
    texel = np.round(255 * (normal + 1) / 2).astype(np.uint8)
    Image.fromarray(np.tile(texel, (4, 4, 1))).save(folder / "bent.png")
    return folder / "bent.png"


def obj(folder: Path, faces: str = "f 1/1 2/2 3/3 4/4\n", quad: str = QUAD) -> Scene:
    (folder / "a.mtl").write_text(BENT)
    (folder / "a.obj").write_text(f"mtllib a.mtl\n{quad}usemtl m\n{faces}")
    return open_scene(folder / "a.obj")


def normal(scene: Scene, origin: Any = (0.3, -0.2, 3), towards: Any = (0, 0, -1)) -> np.ndarray:
    """The shading normal where a ray meets the scene, seen along the ray."""
    hit = scene.rays.intersect(np.array([origin], np.float32), np.array([towards], np.float32))
    args = int(hit.triangle[0]), float(hit.b1[0]), float(hit.b2[0])
    assert args[0] >= 0
    back = tuple(-float(c) for c in towards)
    return np.array(normals(scene.geometry, scene.material_table, *args, back)[1])


@pytest.mark.parametrize("kind", ["obj", "glb", "json"])
def test_every_format(tmp_path: Path, kind: str) -> None:
    path = image(tmp_path)
    if kind == "obj":
        scene = obj(tmp_path)
    elif kind == "glb":
        material = trimesh.visual.material.PBRMaterial(normalTexture=Image.open(path))
        uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
        mesh = trimesh.Trimesh(
            vertices=[[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
            faces=[[0, 1, 2], [0, 2, 3]],
            visual=trimesh.visual.TextureVisuals(uv=uv, material=material),
            process=False,
        )
        mesh.export(str(tmp_path / "a.glb"))
        scene = open_scene(tmp_path / "a.glb")
    else:
        material = {"type": "diffuse", "normal": {"texture": "bent.png"}}
        quad = {"name": "quad", "mesh": {"shape": "rectangle", "size": [2, 2]}, "material": "m"}
        (tmp_path / "a.json").write_text(
            json.dumps({"materials": {"m": material}, "objects": [quad]})
        )
        scene = open_scene(tmp_path / "a.json")
    for origin in ((0.3, -0.2, 3), (-0.5, 0.4, 3)):
        assert normal(scene, origin) == pytest.approx(LEANING, abs=2 * BYTE)


def test_strength_of_a_description_and_of_a_gltf(tmp_path: Path) -> None:
    flat = LEANING * (0.5, 0.5, 1)
    flat /= np.linalg.norm(flat)
    image(tmp_path)
    material = {"type": "diffuse", "normal": {"texture": "bent.png", "strength": 0.5}}
    quad = {"name": "quad", "mesh": {"shape": "rectangle", "size": [2, 2]}, "material": "m"}
    (tmp_path / "a.json").write_text(json.dumps({"materials": {"m": material}, "objects": [quad]}))
    assert normal(open_scene(tmp_path / "a.json")) == pytest.approx(flat, abs=2 * BYTE)
    accessor = {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"}
    corners = np.array([[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]], np.float32)
    # glTF counts v from the top.
    uvs = np.array([[0, 1], [1, 1], [1, 0], [0, 0]], np.float32)
    faces = np.array([0, 1, 2, 0, 2, 3], np.uint32)
    data = corners.tobytes() + uvs.tobytes() + faces.tobytes()
    (tmp_path / "a.bin").write_bytes(data)
    attributes = {"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2, "material": 0}
    document = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [attributes]}],
        "materials": [{"name": "m", "normalTexture": {"index": 0, "scale": 0.5}}],
        "textures": [{"source": 0}],
        "images": [{"uri": "bent.png"}],
        "buffers": [{"uri": "a.bin", "byteLength": len(data)}],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 48},
            {"buffer": 0, "byteOffset": 48, "byteLength": 32},
            {"buffer": 0, "byteOffset": 80, "byteLength": 24},
        ],
        "accessors": [
            {**accessor, "min": [-1, -1, 0], "max": [1, 1, 0]},
            {**accessor, "bufferView": 1, "type": "VEC2"},
            {**accessor, "bufferView": 2, "componentType": 5125, "count": 6, "type": "SCALAR"},
        ],
    }
    (tmp_path / "a.gltf").write_text(json.dumps(document))
    assert normal(open_scene(tmp_path / "a.gltf")) == pytest.approx(flat, abs=2 * BYTE)


def test_turned_and_mirrored_coordinates(tmp_path: Path) -> None:
    """The image is fixed to the surface: it leans along with it."""
    image(tmp_path)
    turned = obj(tmp_path, "f 1/2 2/3 3/4 4/1\n")  # by 90 degrees: u runs down
    assert normal(turned) == pytest.approx(LEANING[[1, 0, 2]] * (1, -1, 1), abs=2 * BYTE)
    mirrored = obj(tmp_path, "f 1/2 2/1 3/4 4/3\n")  # u runs to the left, v up
    assert normal(mirrored) == pytest.approx(LEANING * (-1, 1, 1), abs=2 * BYTE)


def test_the_back_is_the_front_pressed_through(tmp_path: Path) -> None:
    image(tmp_path)
    found = normal(obj(tmp_path), (0.3, -0.2, -3), (0, 0, 1))
    assert found == pytest.approx(-LEANING, abs=2 * BYTE)


def test_it_bends_the_interpolated_normal(tmp_path: Path) -> None:
    """About a normal that leans already, and x still runs along u."""
    lean = np.array([0.0, np.sin(0.4), np.cos(0.4)])
    image(tmp_path, np.array([np.sin(0.3), 0.0, np.cos(0.3)]))
    vn = f"vn {lean[0]} {lean[1]} {lean[2]}\n"
    found = normal(obj(tmp_path, "f 1/1/1 2/2/1 3/3/1 4/4/1\n", QUAD + vn))
    expected = np.sin(0.3) * np.array([1.0, 0, 0]) + np.cos(0.3) * lean
    assert found == pytest.approx(expected, abs=3 * BYTE)


def test_without_coordinates_it_stays_smooth_and_says_so(tmp_path: Path) -> None:
    image(tmp_path)
    scene = obj(tmp_path, "f 1 2 3 4\n", "".join(QUAD.splitlines(True)[:4]))
    assert normal(scene) == pytest.approx([0, 0, 1])
    said = {d.code: d.message for d in scene.diagnoses}
    assert "stay smooth" in said["no_texture_coordinates"]


def test_an_image_of_grey_is_no_direction(tmp_path: Path) -> None:
    """(0, 0, 0) cannot be a normal, and bends nothing."""
    Image.fromarray(np.full((2, 2, 3), 127, np.uint8)).save(tmp_path / "bent.png")
    assert np.isfinite(normal(obj(tmp_path))).all()


@pytest.mark.parametrize("strength", [-1, 11, float("nan")])
def test_a_strength_out_of_range_is_refused(strength: float) -> None:
    with pytest.raises(ValueError, match="strength"):
        NormalMap(texture="bent.png", strength=strength)


def test_a_missing_file_names_its_field(described: Callable[..., Scene]) -> None:
    material = {"type": "diffuse", "normal": {"texture": "gone.png"}}
    with pytest.raises(Exception, match=r"materials\.m\.normal\.texture") as caught:
        described(materials={"m": material})
    assert "gone.png" in str(caught.value)
