"""Mesh files: every format comes back as it was written, and broken files say so."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from hostile import QUAD
from PIL import Image

from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.errors import SceneError
from engine.light.spot import SpotLight
from engine.scene import mesh_files
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.scene.textures import MAX_SIDE, read_image

# A 2 x 2 image as a person sees it: red and green above, blue and white below.
SEEN = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], np.uint8)


def codes(scene: Scene) -> list[str]:
    return [diagnosis.code for diagnosis in scene.diagnoses]


def box(kind: str, path: Path) -> Path:
    path = path / f"box.{kind}"
    trimesh.creation.box(extents=(1, 2, 3)).export(str(path))
    return path


@pytest.mark.parametrize("kind", mesh_files.FORMATS)
def test_a_box_comes_back_from_every_format(tmp_path: Path, kind: str) -> None:
    if kind == "gltf":
        for name, data in (
            trimesh.Scene(trimesh.creation.box(extents=(1, 2, 3))).export(file_type="gltf").items()
        ):
            (tmp_path / name).write_bytes(data)
        path = tmp_path / "model.gltf"
    else:
        path = box(kind, tmp_path)
    geometry = open_scene(path).geometry
    assert len(geometry.triangles) == 12
    corners = geometry.positions[geometry.triangles].astype(np.float64)
    volume = np.sum(corners[:, 0] * np.cross(corners[:, 1], corners[:, 2])) / 6
    assert volume == pytest.approx(6)
    assert np.allclose(np.ptp(geometry.positions, axis=0), [1, 2, 3])


def obj(folder: Path, faces: str, mtl: str = "", before: str = QUAD) -> Path:
    (folder / "a.mtl").write_text(mtl)
    (folder / "a.obj").write_text(f"mtllib a.mtl\n{before}{faces}")
    return folder / "a.obj"


@pytest.mark.parametrize("kind", ["obj", "glb", "json"])
def test_a_texture_shows_the_right_corner(
    tmp_path: Path, look: Callable[..., Any], kind: str
) -> None:
    Image.fromarray(SEEN).save(tmp_path / "seen.png")
    if kind == "obj":
        mtl = "newmtl m\nKd 1 1 1\nmap_Kd seen.png\n"
        path = obj(tmp_path, "usemtl m\nf 1/1 2/2 3/3 4/4\n", mtl)
    elif kind == "glb":
        material = trimesh.visual.material.PBRMaterial(
            baseColorTexture=Image.open(tmp_path / "seen.png"), metallicFactor=0.0
        )
        uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
        mesh = trimesh.Trimesh(
            vertices=[[-1, -1, 0], [1, -1, 0], [1, 1, 0], [-1, 1, 0]],
            faces=[[0, 1, 2], [0, 2, 3]],
            visual=trimesh.visual.TextureVisuals(uv=uv, material=material),
            process=False,
        )
        path = tmp_path / "a.glb"
        mesh.export(str(path))
    else:
        document = {
            "materials": {"m": {"type": "diffuse", "diffuse": {"texture": "seen.png"}}},
            "objects": [
                {
                    "name": "quad",
                    "mesh": {"shape": "rectangle", "size": [2, 2]},
                    "material": "m",
                }
            ],
        }
        path = tmp_path / "a.json"
        path.write_text(json.dumps(document))
    scene = open_scene(path)
    for x, y, pixel in ((-1, 1, (0, 0)), (1, 1, (0, 1)), (-1, -1, (1, 0)), (1, -1, (1, 1))):
        seen = look(scene, (0.5 * x, 0.5 * y, 3), (0, 0, -1)).row[:3]
        assert np.allclose(seen, SEEN[pixel] / 255, atol=1e-5), (x, y)


def test_texels_are_decoded_from_srgb_and_multiply_the_constant(
    tmp_path: Path, look: Callable[..., Any]
) -> None:
    Image.fromarray(np.full((4, 4, 3), 128, np.uint8)).save(tmp_path / "grey.png")
    mtl = "newmtl m\nKd 0.5 1 1\nmap_Kd grey.png\n"
    scene = open_scene(obj(tmp_path, "usemtl m\nf 1/1 2/2 3/3 4/4\n", mtl))
    # IEC 61966-2-1: 128 of 255 is 0.2158605 in linear light.
    expected = 0.2158605 * np.array([0.5, 1, 1])
    assert np.allclose(look(scene, (0, 0, 3), (0, 0, -1)).row[:3], expected, atol=1e-6)


def test_mtl_colours_become_ours(tmp_path: Path) -> None:
    mtl = """
newmtl matt
Kd 0.2 0.4 0.6
Ks 0 0 0
Ns 10
newmtl shiny
Kd 0.5 0.5 0.5
Ks 0.1 0.2 0.3
Ns 40
Ke 1 2 3
newmtl too bright
Kd 1 0.5 0.5
Ks 0.5 0.5 0.5
newmtl glass
Kd 0.5 0.5 0.5
d 0.3
"""
    names = ("matt", "shiny", "too bright", "glass")
    faces = "".join(f"usemtl {name}\nf 1/1 2/2 3/3\n" for name in names)
    scene = open_scene(obj(tmp_path, faces, mtl))
    found = dict(zip(scene.material_names, scene.materials, strict=True))
    assert found["matt"] == Diffuse(emission=(0, 0, 0), diffuse=(0.2, 0.4, 0.6))
    assert found["shiny"] == BlinnPhong(
        emission=(1, 2, 3), diffuse=(0.5, 0.5, 0.5), specular=(0.1, 0.2, 0.3), exponent=40
    )
    # Lowered as a whole, so that the hue stays.
    assert np.allclose(found["too bright"].diffuse, (0.5, 0.25, 0.25))
    assert {"reflectance_limited", "opaque"} <= set(codes(scene))
    assert np.allclose(scene.material_table.emission.max(axis=0), [1, 2, 3])


def test_textures_named_with_backslashes_or_elsewhere_are_found(tmp_path: Path) -> None:
    Image.fromarray(SEEN).save(tmp_path / "Seen.PNG")
    for name in ("textures\\Seen.PNG", "C:\\art\\seen.png", "maps/Seen.PNG", "-s 1 1 1 Seen.PNG"):
        mtl = f"newmtl m\nKd 1 1 1\nmap_Kd {name}\n"
        scene = open_scene(obj(tmp_path, "usemtl m\nf 1/1 2/2 3/3 4/4\n", mtl))
        assert len(scene.material_table.texels) == 4, name
        assert "missing_file" not in codes(scene)


def test_nothing_outside_the_folder_is_read(tmp_path: Path) -> None:
    Image.fromarray(SEEN).save(tmp_path / "secret.png")
    folder = tmp_path / "scene"
    folder.mkdir()
    for name in ("../secret.png", str(tmp_path / "secret.png")):
        mtl = f"newmtl m\nKd 1 1 1\nmap_Kd {name}\n"
        scene = open_scene(obj(folder, "usemtl m\nf 1/1 2/2 3/3 4/4\n", mtl))
        assert len(scene.material_table.texels) == 0
        assert "missing_file" in codes(scene)


def test_missing_files_are_said_and_survived(tmp_path: Path) -> None:
    mtl = "newmtl m\nKd 0.1 0.2 0.3\nmap_Kd gone.png\n"
    path = obj(tmp_path, "usemtl m\nf 1/1 2/2 3/3 4/4\n", mtl)
    scene = open_scene(path)
    assert any("gone.png" in d.message for d in scene.diagnoses)
    assert np.allclose(scene.material_table.row[0, :3], [0.1, 0.2, 0.3])
    (tmp_path / "a.mtl").unlink()
    scene = open_scene(path)
    assert any("a.mtl" in d.message for d in scene.diagnoses)
    assert scene.material_names == ("grey",)


def test_a_texture_that_is_no_image(tmp_path: Path) -> None:
    (tmp_path / "bad.png").write_bytes(b"no image")
    mtl = "newmtl m\nKd 1 1 1\nmap_Kd bad.png\n"
    document = {
        "materials": {"m": {"type": "diffuse", "diffuse": {"texture": "bad.png"}}},
        "objects": [{"name": "quad", "mesh": {"shape": "rectangle"}, "material": "m"}],
    }
    (tmp_path / "a.json").write_text(json.dumps(document))
    with pytest.raises(SceneError, match=r"bad\.png.*image"):
        open_scene(tmp_path / "a.json")
    scene = open_scene(obj(tmp_path, "usemtl m\nf 1/1 2/2 3/3 4/4\n", mtl))
    assert len(scene.material_table.texels) == 0


def test_large_textures_are_averaged_down(tmp_path: Path) -> None:
    checks = (np.indices((8, 2 * MAX_SIDE)).sum(axis=0) % 2 * 255).astype(np.uint8)
    Image.fromarray(checks).save(tmp_path / "checks.png")
    image, side = read_image(tmp_path / "checks.png", "checks.png", srgb=True)
    assert side == 2 * MAX_SIDE
    assert image.shape == (4, MAX_SIDE, 3)
    # In linear light: black and white average to one half, whatever sRGB says.
    assert np.allclose(image, 0.5, atol=1e-6)


def test_indices_from_the_end_count_from_where_they_stand(tmp_path: Path) -> None:
    second = QUAD.replace("v -1", "v 9").replace("v 1", "v 11")
    text = f"{QUAD}f -4/-4 -3/-3 -2/-2 -1/-1\n{second}f -4/-4 -3/-3 -2/-2 -1/-1\n"
    geometry = open_scene(obj(tmp_path, text, before="")).geometry
    assert len(geometry.triangles) == 4
    x = np.sort(geometry.positions[geometry.triangles].mean(axis=(1, 2)))
    assert x[1] < 1 < x[2]


@pytest.mark.parametrize(
    ("name", "content", "word"),
    [
        ("a.obj", b"", "triangles"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n", "triangles"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n", "vertex"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv nan 1 0\nf 1 2 3\n", "finite"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv inf 1 0\nf 1 2 3\n", "finite"),
        ("a.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "zero area"),
        ("a.obj", b"\x00\x01\x02\xff", "triangles|read"),
        ("a.ply", b"ply\nformat ascii 1.0\n", "read"),
        ("a.ply", b"", "read"),
        ("a.stl", b"", "read|triangles"),
        ("a.stl", b"\x00" * 90, "read|triangles"),
        ("a.glb", b"glTF", "glTF"),
        ("a.glb", b"", "glTF"),
        ("a.gltf", b"{}", "asset"),
        ("a.gltf", b'{"asset": {"version": "2.0"}}', "read|triangles"),
        ("a.gltf", b'{"asset": {"version": "2.0"}, "nodes": [{"mesh": 4}]}', "mesh 4"),
    ],
)
def test_broken_files_name_themselves(tmp_path: Path, name: str, content: bytes, word: str) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError, match=word) as caught:
        open_scene(tmp_path / name)
    assert caught.value.file == name


def test_a_ply_with_indices_past_its_end(tmp_path: Path) -> None:
    (tmp_path / "a.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 9\n"
    )
    with pytest.raises(SceneError, match="vertex") as caught:
        open_scene(tmp_path / "a.ply")
    assert caught.value.file == "a.ply"


def glb(path: Path, **material: Any) -> Path:
    mesh = trimesh.creation.box()
    uv = np.zeros((len(mesh.vertices), 2)) + 0.5
    mesh.visual = trimesh.visual.TextureVisuals(
        uv=uv, material=trimesh.visual.material.PBRMaterial(name="m", **material)
    )
    mesh.export(str(path / "a.glb"))
    return path / "a.glb"


@pytest.mark.parametrize("metallic", [0.0, 0.5, 1.0])
def test_metallic_roughness_becomes_diffuse_and_ggx(tmp_path: Path, metallic: float) -> None:
    base = np.array([0.8, 0.4, 0.2])
    path = glb(
        tmp_path,
        baseColorFactor=[*base, 1.0],
        metallicFactor=metallic,
        roughnessFactor=0.3,
        emissiveFactor=[0.1, 0.2, 0.3],
    )
    material = open_scene(path).materials[0]
    assert isinstance(material, Ggx)
    assert np.allclose(material.diffuse, base * (1 - metallic), atol=3e-3)
    assert np.allclose(material.specular, 0.04 * (1 - metallic) + base * metallic, atol=3e-3)
    assert material.roughness == pytest.approx(0.3)
    assert material.emission == pytest.approx((0.1, 0.2, 0.3))


def test_metallic_roughness_textures_do_the_same_texel_by_texel(
    tmp_path: Path, look: Callable[..., Any]
) -> None:
    # Green is roughness, blue is metallic; the smaller image grows to the size of the larger.
    rough = Image.fromarray(np.full((4, 4, 3), (0, 102, 51), np.uint8))
    colour = Image.fromarray(np.full((2, 2, 3), 255, np.uint8))
    path = glb(
        tmp_path,
        baseColorFactor=[0.5, 0.5, 0.5, 1.0],
        baseColorTexture=colour,
        metallicRoughnessTexture=rough,
        metallicFactor=1.0,
        roughnessFactor=0.5,
    )
    row = look(open_scene(path), (0, 0, 3), (0, 0, -1)).row
    assert row[:3] == pytest.approx(0.5 * 0.8, abs=3e-3)
    assert row[3:6] == pytest.approx(0.04 * 0.8 + 0.5 * 0.2, abs=3e-3)
    assert row[6] == pytest.approx(0.5 * 0.4, abs=1e-4)


def test_nodes_of_a_gltf_are_placed_and_read_once(tmp_path: Path, monkeypatch: Any) -> None:
    scene = trimesh.Scene()
    mesh = trimesh.creation.box()
    for k in range(3):
        matrix = trimesh.transformations.translation_matrix([5 * k, 0, 0])
        scene.add_geometry(mesh, node_name=f"n{k}", geom_name="box", transform=matrix)
    scene.export(str(tmp_path / "a.glb"))
    opened = open_scene(tmp_path / "a.glb")
    assert len(opened.object_names) == 3
    centres = [
        opened.geometry.positions[opened.geometry.triangles[opened.geometry.object == k]].mean()
        for k in range(3)
    ]
    assert np.allclose(np.sort(centres), [0, 5 / 3, 10 / 3], atol=1e-5)


def test_one_file_used_by_many_objects_is_read_once(tmp_path: Path, monkeypatch: Any) -> None:
    box("ply", tmp_path)
    reads = []
    original = mesh_files.read_mesh_file
    monkeypatch.setattr(
        "engine.scene.build.read_mesh_file", lambda path: reads.append(path) or original(path)
    )
    objects = [
        {"name": f"box {k}", "mesh": "box.ply", "transform": {"translate": [4 * k, 0, 0]}}
        for k in range(5)
    ]
    (tmp_path / "a.json").write_text(json.dumps({"objects": objects}))
    scene = open_scene(tmp_path / "a.json")
    assert len(reads) == 1
    assert len(scene.geometry.triangles) == 60
    assert np.ptp(scene.geometry.positions[:, 0]) == pytest.approx(17)


def test_lights_and_camera_of_a_gltf(tmp_path: Path) -> None:
    files = trimesh.Scene(trimesh.creation.box()).export(file_type="gltf")
    for name, data in files.items():
        (tmp_path / name).write_bytes(data)
    header = json.loads(files["model.gltf"])
    light = {
        "type": "spot",
        "intensity": 683.0,
        "color": [1, 0.5, 0.25],
        "spot": {"outerConeAngle": np.pi / 6, "innerConeAngle": np.pi / 12},
    }
    header["extensions"] = {"KHR_lights_punctual": {"lights": [light]}}
    header["extensionsUsed"] = ["KHR_lights_punctual"]
    header["cameras"] = [{"type": "perspective", "perspective": {"yfov": 0.5, "aspectRatio": 2}}]
    half = float(np.sqrt(0.5))
    # Turned a quarter about x: what looked along -z looks along +y.
    turned = {"rotation": [half, 0, 0, half], "translation": [1, 2, 3]}
    header["nodes"] += [
        {"name": "lamp", "extensions": {"KHR_lights_punctual": {"light": 0}}, **turned},
        {"name": "eye", "camera": 0, "translation": [0, 0, 5]},
    ]
    header["scenes"][0]["nodes"] += [len(header["nodes"]) - 2, len(header["nodes"]) - 1]
    (tmp_path / "model.gltf").write_text(json.dumps(header))
    scene = open_scene(tmp_path / "model.gltf")
    (lamp,) = scene.lights
    assert isinstance(lamp, SpotLight)
    assert lamp.intensity == pytest.approx((1, 0.5, 0.25))
    assert lamp.position == pytest.approx((1, 2, 3))
    assert np.subtract(lamp.target, lamp.position) == pytest.approx([0, 1, 0])
    assert (lamp.cone_degrees, lamp.penumbra_degrees) == pytest.approx((30, 15))
    assert scene.camera.position == pytest.approx((0, 0, 5))
    assert np.subtract(scene.camera.target, scene.camera.position) == pytest.approx([0, 0, -1])
    assert scene.camera.fov_y_degrees == pytest.approx(np.degrees(0.5))
    assert (scene.camera.width, scene.camera.height) == (960, 480)
    assert "default_lights" not in codes(scene)
