"""The GPU draws what the CPU draws."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.glossy_prt.test_glossy_prt import BRUSHED, GREY, SMALL, ball, still_life
from methods.scenes import camera, rectangle, small_knot
from numpy.typing import NDArray
from PIL import Image

from engine.backend.choice import GlFirst
from engine.backend.gl import context
from engine.backend.gl.context import device
from engine.backend.gl.seen import Sight
from engine.backend.gl.vectors import StoredVectors
from engine.errors import BackendError, InputError
from engine.methods import prepare
from engine.methods.glossy_prt import Prt, Settings
from engine.methods.glossy_prt.gl_prt import GlPrt
from engine.methods.glossy_prt.terms import BOTH_VARY, DIFFUSE_VARIES
from engine.scene.build import build
from engine.scene.edits import Edits
from engine.scene.open import describe
from engine.scene.scene import Scene
from engine.store import Store

pytestmark = pytest.mark.gl
PARTS = {"transport", "view", "shade", "read_back", "total"}
SAME = 1e-3  # relative L2 of a whole frame
FEW = {**SMALL, "light_texels": 16, "visibility_texels": 16, "brdf_texels": 24, "gather_texels": 8}
PHONG = {"type": "phong", "diffuse": [0.3] * 3, "specular": [0.3] * 3, "exponent": 12}
Make = Callable[..., Prt]


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """make(scene, **settings): its product, in a store of this module's own."""
    store = Store(tmp_path_factory.mktemp("store"))

    def product(of: Scene, **settings: Any) -> Prt:
        chosen = Settings(**{**FEW, **settings})
        return prepare(of, "glossy_prt", chosen, store=store)  # type: ignore[return-value]

    return product


def assert_same(product: Prt, edits: Edits = Edits(), scale: int = 1) -> NDArray[np.float32]:  # noqa: B008
    """Both backends draw the same picture, which this returns, and say the same of it."""
    theirs, ours = (product.relight(edits, scale, backend) for backend in ("cpu", "gl"))
    device().check()
    assert ours.warnings == theirs.warnings
    assert set(ours.timings) == PARTS
    assert ours.image.shape == theirs.image.shape
    assert np.isfinite(ours.image).all()
    assert np.linalg.norm(ours.image - theirs.image) <= SAME * np.linalg.norm(theirs.image)
    return ours.image


def with_texture(folder: Path, material: dict[str, Any]) -> Scene:
    """A ball that shines over a floor whose diffuse reflectance is an image, often repeated."""
    rng = np.random.default_rng(1)
    Image.fromarray(rng.integers(30, 255, (8, 16, 3), np.uint8)).save(folder / "noise.png")
    floor = rectangle("floor", [4, 4], [0, -0.52, 0], [-90, 0, 0])
    floor["mesh"] |= {"segments": [12, 12]}
    texture = {"texture": "noise.png", "factor": [0.9, 0.5, 0.7]}
    document = {
        "camera": camera(64, position=[0.6, 1.0, 2.4], target=[0, -0.1, 0], fov_y_degrees=40),
        "environment": {"map": "studio"},
        "lights": [],
        "materials": {
            "floor": {**material, "diffuse": texture},
            "ball": {**GREY, "emission": [0.2, 0.1, 0.4]},
        },
        "objects": [
            {**floor, "material": "floor"},
            {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.5, "rings": 24},
             "material": "ball"},
        ],
    }  # fmt: skip
    made = build(describe(document), folder)
    return replace(made, geometry=made.geometry._replace(uvs=7 * made.geometry.uvs - 103.3))


@pytest.mark.parametrize("scale", [1, 2])
@pytest.mark.parametrize("position", [[0.9, 1.9, 3.1], [-2.0, 0.3, 1.0]])
def test_knot(make: Make, scale: int, position: list[float]) -> None:
    product = make(small_knot(75, 56), bounces=1)
    assert len(product.terms) == 2
    assert_same(product, Edits(camera={"position": position}), scale)


def test_coloured_gloss_and_a_bounce_in_three_channels(make: Make) -> None:
    red = {"type": "phong", "diffuse": [0.5, 0.1, 0.1], "specular": [0.2, 0.3, 0.1], "exponent": 20}
    product = make(still_life(red, ground=(0.2, 0.6, 0.3), segments=16), bounces=1)
    assert product.transport.bounced[0].scale.shape[1] == 3 * product.terms[0].count
    assert_same(product)


@pytest.mark.parametrize("material", [GREY, PHONG], ids=lambda material: material["type"])
def test_a_texture(make: Make, tmp_path: Path, material: dict[str, Any]) -> None:
    product = make(with_texture(tmp_path, material))
    assert product.terms[0].textured == DIFFUSE_VARIES
    assert_same(product)


def test_a_texture_of_gloss(make: Make, tmp_path: Path) -> None:
    gloss = {"texture": "noise.png", "factor": [0.3, 0.6, 0.2]}
    product = make(with_texture(tmp_path, {**PHONG, "specular": gloss}))
    assert product.terms[0].textured == BOTH_VARY
    assert_same(product)


def test_grain_that_turns_within_triangles(make: Make) -> None:
    """Where frames at the corners are no one field, each corner is looked up in its own."""
    product = make(small_knot(segments=24))
    smooth = product.vertices.smooth
    assert smooth.any()
    assert not smooth.all()
    assert_same(product)


def test_the_pole_of_frames_that_have_no_grain(make: Make) -> None:
    product = make(ball(PHONG, size=64))
    smooth = product.vertices.smooth
    assert smooth.any()
    assert not smooth.all()
    below = {"position": [0.1, -1.2, 0.1], "target": [0, 0, 0], "fov_y_degrees": 40}
    assert_same(product, Edits(environment={"map": "studio"}, camera=below))


@pytest.mark.parametrize("height", [1e-4, 2e-3, 0.3])
@pytest.mark.parametrize("scale", [1, 2])
def test_a_camera_very_near_to_the_floor_or_not(make: Make, height: float, scale: int) -> None:
    """The floor goes on behind the camera, and is nearer than what is drawn without rays."""
    product = make(still_life(GREY, segments=16))
    low = {"position": [0.3, -0.52 + height, 1.2], "target": [0, -0.3, 0], "fov_y_degrees": 100}
    assert_same(product, Edits(camera=low), scale)


@pytest.mark.parametrize("size", [(61, 47), (1, 1), (3, 70)])
@pytest.mark.parametrize("scale", [1, 2, 3])
def test_pictures_of_any_size(make: Make, size: tuple[int, int], scale: int) -> None:
    product = make(ball({**BRUSHED, "diffuse": [0.1, 0.5, 0.3]}))
    # Not in the plane of symmetry, where rays meet edges of the mesh and rounding tells which side.
    aside = {"position": [0.3, 0.4, 2], "width": size[0], "height": size[1]}
    assert_same(product, Edits(camera=aside), scale)


@pytest.mark.parametrize("map_", [[0, 0, 0], [0.2, 0.5, 1.0], "noise"], ids=str)
@pytest.mark.parametrize("degrees", [0, 77.7])
def test_what_is_behind(make: Make, tmp_path: Path, map_: Any, degrees: float) -> None:
    if map_ == "noise":
        map_ = str(tmp_path / "noise.png")
        rng = np.random.default_rng(2)
        Image.fromarray(rng.integers(0, 255, (32, 64, 3), np.uint8)).save(map_)
    product = make(ball(BRUSHED))
    fields = {"map": map_, "rotation_degrees": degrees, "intensity": 0.7}
    assert_same(product, Edits(environment=fields, camera={"fov_y_degrees": 90}))


@pytest.mark.parametrize("background", [True, False])
@pytest.mark.parametrize("radius", [1.0, 25.0])
def test_an_area_light_behind_and_no_background(
    make: Make, tmp_path: Path, radius: float, background: bool
) -> None:
    product = make(with_texture(tmp_path, GREY))
    light = {"direction": [-0.9, 0.4, 1], "radius_degrees": radius, "radiance": [5, 4, 3]}
    fields = {"rotation_degrees": 20, "area_light": light, "background": background}
    image = assert_same(product, Edits(environment=fields, camera={"fov_y_degrees": 100}))
    assert (image.max() >= 5) == background


def test_no_environment_at_all(make: Make, tmp_path: Path) -> None:
    textured = with_texture(tmp_path, GREY)
    dark = make(replace(textured, environment=None))
    picture = assert_same(dark)
    assert np.allclose(picture[32, 32], [0.2, 0.1, 0.4])
    assert not picture[0, 0].any()


def test_nothing_is_seen(make: Make) -> None:
    away = {"position": [0, 0.4, 2], "target": [0, 0.4, 4]}
    picture = assert_same(make(ball(GREY)), Edits(camera=away))
    assert np.allclose(picture, 1)


def test_what_was_sent_is_never_stale_and_bytes_are_the_same(make: Make) -> None:
    """Another light, another view, both, and back; and two products in turn."""
    one, two = make(small_knot()), make(still_life(BRUSHED, segments=16))
    first = assert_same(one)
    for edits in (
        Edits(environment={"rotation_degrees": 90}),
        Edits(environment={"rotation_degrees": 90}, camera={"position": [1.5, 1.5, 2.5]}),
        Edits(environment={"map": [0.2, 0.5, 1.0]}),
    ):
        assert np.linalg.norm(assert_same(one, edits) - first) > 0.05 * np.linalg.norm(first)
        assert_same(two, edits)
    assert one.relight(Edits(), 1, "gl").image.tobytes() == first.tobytes()


def test_a_light_and_a_view_that_stay_cost_nothing(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    product = make(small_knot())
    product.relight(Edits(), 1, "gl")
    turned = Edits(environment={"rotation_degrees": 10})
    moved = Edits(environment={"rotation_degrees": 10}, camera={"position": [1, 2, 3]})

    def fail(*_: Any) -> None:
        raise AssertionError("this is known already")

    with monkeypatch.context() as patch:
        patch.setattr(Sight, "look", fail)
        product.relight(turned, 1, "gl")
    monkeypatch.setattr(StoredVectors, "multiply", fail)
    product.relight(moved, 1, "gl")


@pytest.mark.parametrize(("occluders", "error"), [(0, 2e-3), (200, 5e-3)])
def test_visibility_by_gl(make: Make, occluders: int, error: float) -> None:
    """The same light as by rays, but for texels whose centres lie at silhouettes."""
    scene, edits = still_life(PHONG, segments=12), Edits()
    rays = make(scene, coarse_texels=16, occluder_vertices=occluders).relight(edits, 1, "cpu").image
    found = make(scene, visibility="gl", occluder_vertices=occluders).relight(edits, 1, "cpu").image
    assert np.linalg.norm(found - rays) < error * np.linalg.norm(rays)
    assert (found != rays).any()


def test_where_visibility_by_gl_is_not_to_be_had(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(context, "_failure", "no such thing as a GPU")
    with pytest.raises(InputError, match="no such thing as a GPU") as caught:
        make(still_life(GREY, segments=4), visibility="gl")
    assert caught.value.field == "visibility"


def test_without_being_asked_only_hardware_draws(make: Make) -> None:
    frame = make(ball(GREY)).relight(Edits(), 1, "auto")
    assert ("read_back" in frame.timings) != device().software
    assert not frame.warnings


def test_gl_that_is_missing_is_replaced_by_the_cpu(
    make: Make, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(context, "_failure", "no such thing as a GPU")
    product = copy(make(ball(GREY)))
    frame = product.relight(Edits(), 1, "gl")
    assert [w.code for w in frame.warnings] == ["gl_unavailable"]
    assert "no such thing as a GPU" in frame.warnings[0].message
    assert not product.relight(Edits(), 1, "cpu").warnings
    assert not product.relight(Edits(), 1, "auto").warnings


def test_gl_that_fails_is_replaced_by_the_cpu(make: Make, monkeypatch: pytest.MonkeyPatch) -> None:
    """From the frame on in which it fails, with a plain notice; other products go on with it."""
    product = make(ball(GREY))
    other, expected = copy(product), product.relight(Edits(), 1, "cpu")
    other._backend = GlFirst()

    def fail(*_: Any) -> None:
        raise BackendError("the GPU has fallen off")

    with monkeypatch.context() as patch:
        patch.setattr(GlPrt, "draw", fail)
        for _ in range(2):
            frame = other.relight(Edits(), 1, "gl")
            assert frame.image.tobytes() == expected.image.tobytes()
            assert [w.code for w in frame.warnings] == ["gl_unavailable"]
            assert "has fallen off" in frame.warnings[0].message
    assert "read_back" not in other.relight(Edits(), 1, "gl").timings
    assert "read_back" in product.relight(Edits(), 1, "gl").timings
