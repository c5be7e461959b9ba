"""The projector: what falls on a wall, its power, its detail, and the files that it names."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest
from light.lights import illuminate
from PIL import Image

from engine.errors import EditError, SceneError
from engine.light.projector import ProjectorLight
from engine.light.table import light_table
from engine.scene.edits import Edits, apply, edited_lights
from engine.scene.open import open_scene
from engine.scene.scene import Scene

UP = {"position": (0.0, 0.0, 0.0), "target": (0.0, 0.0, -5.0)}


def projector(**fields: object) -> ProjectorLight:
    return ProjectorLight.model_validate({"id": "p", **UP, "image": "chart", **fields})


def wall(light: ProjectorLight, x: float, y: float, z: float = 2.0) -> np.ndarray:
    """Irradiance of the wall at -z, at x to the right and y up of its middle."""
    value = illuminate(light, (x, y, -z), (0.5, 0.5))[0]
    return value[4:] * value[2]  # the wall's normal is +z


def test_the_image_stands_upright_and_unmirrored() -> None:
    """Seen from the projector: red, green above, white, blue below (the bright squares)."""
    light = projector(fov_y_degrees=90)
    near, far = 0.28, 0.72  # two squares out, both ways
    for x, y, colour in (
        (-far, far, (1, 0, 0)),
        (far, near, (0, 1, 0)),
        (far, -far, (0, 0, 1)),
        (-far, -near, (1, 1, 1)),
    ):
        np.testing.assert_allclose(wall(light, 2 * x, 2 * y) * 4, colour, atol=1e-5)
    assert (wall(light, 2.001, 0) == 0).all()
    assert (wall(light, 0, -2.001) == 0).all()
    assert (wall(light, 0.1, 0.1, z=-2) == 0).all()


def test_up_turns_the_image() -> None:
    turned = projector(fov_y_degrees=90, up=(1, 0, 0))
    straight = projector(fov_y_degrees=90)
    for x, y in ((0.3, 0.9), (-0.55, 0.2)):
        np.testing.assert_allclose(wall(turned, y, -x), wall(straight, x, y), atol=1e-6)


def test_a_wall_keeps_the_brightness_of_white() -> None:
    """E = I T / z² all over a wall at right angles (T = 1 in bright squares)."""
    light = projector(fov_y_degrees=120, intensity=(5, 5, 5))
    reach = math.tan(math.radians(60))
    square = reach / 4
    centres = [(-0.5, -1.5), (-3.5, -0.5), (-2.5, -1.5), (-3.5, -2.5)]
    for z in (0.1, 3.0):
        for i, j in centres:
            found = wall(light, i * square * z, j * square * z, z)
            np.testing.assert_allclose(found, 5 / z**2, rtol=1e-5)


@pytest.mark.parametrize("fov", [5.0, 60.0, 150.0])
@pytest.mark.parametrize("image", ["window", "leaves"])
def test_power(fov: float, image: str) -> None:
    """∫ I dω = I mean(T) 4 tan(fov_x / 2) tan(fov_y / 2), whatever the size that is looked up."""
    light = projector(fov_y_degrees=fov, image=image, position=(1, 2, 3), target=(4, -2, 1))
    row, picture = light.row().astype(float), light.pyramid()
    n = 384
    s, t = (a.ravel() for a in np.meshgrid(*[(np.arange(n) + 0.5) / n * 2 - 1] * 2))
    tangent = math.tan(math.radians(fov / 2))
    wide = tangent * picture.width / picture.height
    d = row[3:6] + wide * s[:, None] * row[9:12] + tangent * t[:, None] * row[12:15]
    cosine = 1 / np.linalg.norm(d, axis=1)
    mean = picture.texels[: picture.width * picture.height].mean(axis=0)
    for size in (0.0, 0.01, 10.0):
        # At 1 m radiant intensity and irradiance are one number.
        value = illuminate(light, row[:3] + d * cosine[:, None], (0.5, 0.5), size)
        power = (value[:, 4:] * (cosine**3)[:, None]).mean(axis=0) * 4 * wide * tangent
        np.testing.assert_allclose(power, mean * 4 * wide * tangent, rtol=4e-3)


def test_detail_below_the_receiver_s_size_fades() -> None:
    """Small receivers see the squares, large ones the mean; nothing jumps in between."""
    light = projector(fov_y_degrees=60)
    x = np.column_stack([np.linspace(-1, 1, 400), np.full(400, -0.3), np.full(400, -2.0)])
    contrast = []
    for size in (0.0, 0.01, 0.1, 1.0, 100.0):
        value = illuminate(light, x, (0.5, 0.5), size)[:, 4] * 4
        contrast.append(value.std() / value.mean())
    assert contrast[0] == pytest.approx(contrast[1], rel=0.05)
    assert contrast[0] > contrast[2] > contrast[3] > contrast[4]
    assert contrast[0] > 0.5
    sizes = np.geomspace(1e-3, 10, 4000)
    values = np.array([illuminate(light, (-0.4, 0.5, -2), (0.5, 0.5), s)[0, 4] for s in sizes])
    assert np.abs(np.diff(values)).max() < 2e-3 * values.max()
    # Twice as far, the same share of the image: only size / distance counts.
    near = illuminate(light, (-0.4, 0.5, -2), (0.5, 0.5), 0.2)[0, 4]
    far = illuminate(light, (-0.8, 1, -4), (0.5, 0.5), 0.4)[0, 4]
    assert far == pytest.approx(near / 4, rel=1e-6)


def test_images_share_a_table() -> None:
    """Each light of a table finds its own image; one that two throw is there once."""
    a, b, c = projector(image="chart"), projector(image="leaves"), projector(image="chart")
    table = light_table([a, b, c])
    once = len(a.pyramid().texels) + len(b.pyramid().texels)
    assert len(table.texels) == once
    assert table.row[0].tolist() == table.row[2].tolist()
    assert table.row[1, 29] * 64 == len(a.pyramid().texels)


def _scene(folder: Path, **light: object) -> Path:
    document = {
        "lights": [{"id": "p", "type": "projector", "position": [0, 0, 2], "target": [0, 0, 0]}],
        "objects": [{"name": "wall", "mesh": {"shape": "rectangle", "size": [2, 2]}}],
    }
    document["lights"][0].update(light)  # type: ignore[attr-defined]
    path = folder / "scene.json"
    path.write_text(json.dumps(document))
    return path


@pytest.fixture
def scene(tmp_path: Path) -> Scene:
    Image.fromarray(np.full((4, 8, 3), 255, np.uint8)).save(tmp_path / "white.png")
    Image.fromarray(np.zeros((4, 8, 3), np.uint8)).save(tmp_path / "black.png")
    return open_scene(_scene(tmp_path, image="white.png"))


def test_files_lie_beside_the_scene(scene: Scene) -> None:
    """When the scene is opened and when an edit names another one, which a later one keeps."""
    (light,) = scene.lights
    assert illuminate(light, (0, 0, 0), (0.5, 0.5))[0, 4] == pytest.approx(0.25)
    black = apply(scene, Edits(lights=[{"id": "p", "image": "black.png"}]))
    assert illuminate(black.lights[0], (0, 0, 0), (0.5, 0.5))[0, 4] == 0
    moved = apply(black, Edits(lights=[{"id": "p", "position": [0, 0, 1]}]))
    assert illuminate(moved.lights[0], (0, 0, 0), (0.5, 0.5))[0, 4] == 0
    back = apply(moved, Edits(lights=[light.model_dump()]))
    assert back.lights == scene.lights
    assert hash(back.lights) == hash(scene.lights)


def test_bad_images_name_field_and_file(scene: Scene, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match="no such file") as bad:
        open_scene(_scene(tmp_path, image="none.png"))
    assert bad.value.field == "lights.0.image"
    assert bad.value.file == "none.png"
    with pytest.raises(EditError, match="no such file") as wrong:
        edited_lights(scene.lights, [{"id": "p", "image": "none.png"}], scene.folder)
    assert wrong.value.field == "lights.0.image"
    assert wrong.value.file == "none.png"
    for fields, words in (
        ({"fov_y_degrees": 180}, "less than or equal to 170"),
        ({"up": [0, 0, 0]}, "up is zero"),
        ({"target": [0, 0, 2]}, "same point"),
        ({"image": ""}, "at least 1 character"),
    ):
        with pytest.raises(EditError, match=words):
            edited_lights(scene.lights, [{"id": "p", **fields}], scene.folder)
