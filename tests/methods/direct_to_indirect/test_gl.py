"""The GPU draws what the CPU draws."""

from __future__ import annotations

from copy import copy
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.fixed_view.test_kinds import KINDS
from methods.scenes import cornell
from PIL import Image

from engine.backend.choice import GlFirst
from engine.backend.gl.context import device
from engine.errors import BackendError
from engine.methods import Product, prepare
from engine.methods.direct_to_indirect import Settings, Transfer
from engine.methods.direct_to_indirect.gl_transfer import GlTransfer
from engine.methods.direct_to_indirect.light_balance import LightBalance
from engine.scene.build import build
from engine.scene.edits import Edits
from engine.scene.open import describe
from engine.scene.scene import Scene
from engine.store import Store

pytestmark = pytest.mark.gl
PARTS = {"gather_direct", "bounces", "final_gather", "view_direct", "compose", "total"}
SAME = 1e-3  # relative L2 of a whole frame
SMALL = Settings(gather_samples=1024, coefficients=30, bounce_coefficients=20)


def different(product: Product, edits: Edits, scale: int) -> float:
    """Relative L2 difference of the pictures of both backends, which say the same of them."""
    theirs, ours = (product.relight(edits, scale, backend) for backend in ("cpu", "gl"))
    device().check()
    assert [w.message for w in ours.warnings] == [w.message for w in theirs.warnings]
    for mine, other in zip(ours.warnings, theirs.warnings, strict=True):
        assert mine.size == pytest.approx(other.size, rel=SAME)
    assert set(ours.timings) >= PARTS
    assert np.isfinite(ours.image).all()
    assert ours.image.shape == theirs.image.shape
    assert theirs.image.max() > 0
    return float(np.linalg.norm(ours.image - theirs.image) / np.linalg.norm(theirs.image))


@pytest.fixture(scope="module")
def box(tmp_path_factory: pytest.TempPathFactory) -> Transfer:
    store = Store(tmp_path_factory.mktemp("store"))
    return prepare(cornell(64), "direct_to_indirect", SMALL, store=store)  # type: ignore[return-value]


@pytest.mark.parametrize("scale", [1, 2])
@pytest.mark.parametrize("x", [0.2, 0.35])
def test_cornell_box(box: Transfer, scale: int, x: float) -> None:
    """A lamp and a spot, in two places."""
    first, _ = box.view.scene.lights
    moved = Edits(lights=[{"id": first.id, "position": [x, 0.5, 0.25]}])
    assert different(box, moved, scale) < SAME
    only = Edits(lights=[{"id": first.id, "enabled": False}])
    assert different(box, only, scale) < SAME


def shiny(folder: Path, width: int = 75, height: int = 56) -> Scene:
    """A room corner of textures and every kind of gloss under all lights and a sky.

    The sizes are no multiples of a tile.
    """
    rng = np.random.default_rng(1)
    Image.fromarray(rng.integers(30, 255, (16, 16, 3), np.uint8)).save(folder / "noise.png")
    texture = {"texture": "noise.png"}
    materials = {
        "floor": {"type": "ggx", "diffuse": texture, "roughness": 0.4},
        "wall": {"type": "blinn_phong", "diffuse": texture, "specular": [0.1] * 3, "exponent": 30},
        "ball": {"type": "phong", "diffuse": [0.1, 0.2, 0.4], "specular": [0.6] * 3,
                 "exponent": 200},
        "block": {"type": "ggx", "diffuse": [0] * 3, "specular": [0.9, 0.7, 0.4],
                  "roughness": 0.25},
        "matt": {"type": "diffuse", "diffuse": texture},
    }  # fmt: skip
    square = {"shape": "rectangle", "size": [2, 2]}
    flat = {"rotate_degrees": [-90, 0, 0]}
    objects = [
        {"name": "floor", "mesh": square, "material": "floor", "transform": flat},
        {"name": "wall", "mesh": square, "material": "wall",
         "transform": {"translate": [0, 0.5, -1]}},
        {"name": "side", "mesh": square, "material": "matt",
         "transform": {"translate": [-1, 0.5, 0], "rotate_degrees": [0, 90, 0]}},
        {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.3}, "material": "ball",
         "transform": {"translate": [0.4, 0.3, 0.1]}},
        {"name": "block", "mesh": {"shape": "box", "size": [0.4, 0.5, 0.4]}, "material": "block",
         "transform": {"translate": [-0.35, 0.25, -0.2]}},
    ]  # fmt: skip
    lights = [{"id": k, "type": k, "intensity": [1, 2, 4], **v} for k, v in KINDS.items()]
    camera: dict[str, Any] = {"position": [0.4, 0.9, 2.2], "target": [0, 0.2, 0]}
    camera |= {"fov_y_degrees": 45, "width": width, "height": height}
    document = {
        "camera": camera, "lights": lights, "materials": materials, "objects": objects,
        "environment": {"map": "studio", "intensity": 0.1},
    }  # fmt: skip
    return build(describe(document), folder)


@pytest.fixture(scope="module")
def corner(tmp_path_factory: pytest.TempPathFactory) -> Product:
    folder = tmp_path_factory.mktemp("shiny")
    return prepare(shiny(folder), "direct_to_indirect", SMALL, store=Store(folder))


@pytest.mark.parametrize("scale", [1, 2])
@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_of_light(corner: Product, kind: str, scale: int) -> None:
    alone = Edits(lights=[{"id": other, "enabled": False} for other in KINDS if other != kind])
    assert different(corner, alone, scale) < SAME


@pytest.mark.parametrize("scale", [1, 2])
def test_all_lights_and_none(corner: Product, scale: int) -> None:
    assert different(corner, Edits(), scale) < SAME
    off = Edits(lights=[{"id": kind, "enabled": False} for kind in KINDS])
    assert different(corner, off, scale) < SAME


@pytest.mark.parametrize("scale", [1, 2])
def test_another_environment(corner: Product, scale: int) -> None:
    """Turned, brighter, then a plain one, and back: what was sent to the GPU is never stale."""
    off = [{"id": kind, "enabled": False} for kind in KINDS]
    pictures = []
    for change in ({"rotation_degrees": 90}, {"intensity": 0.7}, {"map": [0.2, 0.5, 1.0]}, {}):
        edits = Edits(lights=off, environment=change)
        assert different(corner, edits, scale) < SAME
        pictures.append(corner.relight(edits, scale, "gl").image)
    for a, b in pairwise(pictures):
        assert np.linalg.norm(a - b) > 0.05 * np.linalg.norm(b)


def test_the_same_bytes_every_time(corner: Product) -> None:
    """Also where a light has moved away and back, and its old picture is still there."""
    first = corner.relight(Edits(), 1, "gl").image
    moved = Edits(lights=[{"id": "spot", "position": [0.5, 1.2, 0.1]}])
    between = corner.relight(moved, 1, "gl").image
    assert corner.relight(Edits(), 1, "gl").image.tobytes() == first.tobytes()
    assert between.tobytes() != first.tobytes()


@pytest.mark.parametrize("scale", [1, 2])
def test_compose(corner: Transfer, scale: int) -> None:
    """Arriving light of either sign, as culling may leave it; what is below 0 is none."""
    corner.relight(Edits(), scale, "gl")
    gl, n = corner._gl, len(corner.view.points(scale))
    assert gl is not None
    rng = np.random.default_rng(6)
    arriving, mirrored = rng.normal(size=(2, n, 3)).astype(np.float32)
    image = rng.random((n, 3)).astype(np.float32)
    for buffer, array in ((gl._arriving, arriving), (gl._mirrored, mirrored), (gl._image, image)):
        buffer.write(array)
    gl._compose(scale, n)
    device().check()
    found = np.frombuffer(gl._image.read(image.nbytes), np.float32).reshape(n, 3)
    corner._compose(arriving, mirrored, image, scale)
    np.testing.assert_allclose(found, image, rtol=1e-5, atol=1e-6)


def test_the_gpu_lights_the_cloud_for_the_diagnoses_too(
    box: Transfer, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What is said of lights and of what the cloud reflects costs the CPU no shadow rays."""
    light = {"type": "spot", "id": "new", "cone_degrees": 4, "intensity": [1, 1, 1]}
    edits = Edits(lights=[{**light, "position": [0.3, 0.4, 0.2], "target": [0.3, 0, 0.2]}])
    expected = box.relight(edits, 1, "cpu").warnings
    assert "light_between_samples" in [w.code for w in expected]
    other = copy(box)
    other._balance = LightBalance(box.view.scene, box.cloud, box._balance._grid)

    def fail(*_: Any) -> None:
        raise AssertionError("the CPU lights the cloud")

    monkeypatch.setattr(Transfer, "_light_on_cloud", fail)
    found = other.relight(edits, 1, "gl").warnings
    assert [w.message for w in found] == [w.message for w in expected]


def test_gl_that_fails_is_replaced_by_the_cpu(
    corner: Product, monkeypatch: pytest.MonkeyPatch
) -> None:
    """From the frame on in which it fails, with a plain notice; other products go on with it."""
    other = copy(corner)
    other._backend = GlFirst()

    def fail(*_: Any) -> None:
        raise BackendError("the GPU has fallen off")

    monkeypatch.setattr(GlTransfer, "draw", fail)
    expected = corner.relight(Edits(), 1, "cpu")
    for _ in range(2):
        frame = other.relight(Edits(), 1, "gl")
        assert frame.image.tobytes() == expected.image.tobytes()
        assert [w.code for w in frame.warnings[: -len(expected.warnings)]] == ["gl_unavailable"]
        assert "has fallen off" in frame.warnings[0].message
    assert other.relight(Edits(), 1, "cpu").warnings == expected.warnings
    monkeypatch.undo()
    assert "read_back" not in other.relight(Edits(), 1, "gl").timings
    assert "read_back" in corner.relight(Edits(), 1, "gl").timings
