"""An environment edited at run time: closed forms, laws, agreement with the reference, honesty."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.scenes import POINT, camera, cornell, rectangle, scene, white_room
from numpy.typing import NDArray

from engine.images import write_image
from engine.light.environment_samples import places_on_map, seen_radiance
from engine.measure.edges import scene_edges
from engine.methods import prepare
from engine.methods.direct_to_indirect import Settings, Transfer
from engine.methods.direct_to_indirect.precompute import NEEDS, key
from engine.methods.fixed_view.preview import DirectPreview
from engine.reference import render
from engine.scene.edits import Edits, apply, edited_camera
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.store import Store

Make = Callable[..., Transfer]
CLEAR_SKY = {"sun_direction": [1, -1, 0.3], "turbidity": 2.5}


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """make(scene, **settings): its product, in a store of this module's own."""
    store = Store(tmp_path_factory.mktemp("store"))

    def product(scene: Scene, **settings: object) -> Transfer:
        chosen = Settings(**{"gather_samples": 1024, **settings})  # type: ignore[arg-type]
        return prepare(scene, "direct_to_indirect", chosen, store=store)  # type: ignore[return-value]

    return product


def sky(**fields: Any) -> Edits:
    return Edits(environment=fields)


def floor(albedo: float = 0.6) -> Scene:
    """A floor under an open sky, from above, and nothing else."""
    return scene(
        camera=camera(16, position=[0, 2, 2], target=[0, 0, 0], fov_y_degrees=40),
        environment={"map": [1, 1, 1]},
        materials={"floor": {"type": "diffuse", "diffuse": [albedo] * 3}},
        objects=[{**rectangle("floor", [9, 9], [0, 0, 0], [-90, 0, 0]), "material": "floor"}],
    )


def window_room(size: int = 32) -> Scene:
    """A room with one window, on the left; a ball of metal and a cube stand on a glossy floor."""

    def left(z: float, y: float, width: float, height: float) -> dict[str, Any]:
        place = rectangle(f"left {z} {y}", [width, height], [-2, y, z], [0, 90, 0])
        return {**place, "material": "wall"}

    sides = [
        ("floor", "boards", [4, 3], [0, 0, 0], [-90, 0, 0]),
        ("ceiling", "wall", [4, 3], [0, 2.6, 0], [90, 0, 0]),
        ("back", "wall", [4, 2.6], [0, 1.3, -1.5], [0, 0, 0]),
        ("front", "wall", [4, 2.6], [0, 1.3, 1.5], [0, 180, 0]),
        ("right", "red", [3, 2.6], [2, 1.3, 0], [0, -90, 0]),
    ]
    return scene(
        camera={
            "position": [1.4, 1.5, 1.3],
            "target": [-0.6, 0.9, -0.8],
            "fov_y_degrees": 65,
            "width": size * 4 // 3,
            "height": size,
        },
        environment={"map": [1, 0.9, 0.8]},
        materials={
            "wall": {"type": "diffuse", "diffuse": [0.7, 0.68, 0.65]},
            "red": {"type": "diffuse", "diffuse": [0.6, 0.15, 0.1]},
            "boards": {
                "type": "ggx",
                "diffuse": [0.3, 0.2, 0.12],
                "specular": [0.04] * 3,
                "roughness": 0.3,
            },
            "brass": {
                "type": "ggx",
                "diffuse": [0, 0, 0],
                "specular": [0.8, 0.6, 0.3],
                "roughness": 0.3,
            },
        },
        objects=[
            *(
                {**rectangle(name, size, at, turn), "material": material}
                for name, material, size, at, turn in sides
            ),
            left(-1.05, 1.3, 0.9, 2.6),
            left(1.05, 1.3, 0.9, 2.6),
            left(0, 0.45, 1.2, 0.9),
            left(0, 2.3, 1.2, 0.6),
            {
                "name": "ball",
                "mesh": {"shape": "sphere", "radius": 0.4},
                "material": "brass",
                "transform": {"translate": [0.3, 0.4, -0.5]},
            },
            {
                "name": "cube",
                "mesh": {"shape": "box", "size": [0.6] * 3},
                "material": "wall",
                "transform": {"translate": [-0.8, 0.3, -0.6]},
            },
        ],
    )


# Closed forms and laws


def test_an_open_floor_reflects_albedo_times_radiance(make: Make) -> None:
    image = make(floor()).relight(Edits()).image
    np.testing.assert_allclose(image, 0.6, rtol=1e-3)
    doubled = make(floor()).relight(sky(map=[2, 1, 0.5])).image
    np.testing.assert_allclose(doubled, np.broadcast_to([1.2, 0.6, 0.3], image.shape), rtol=1e-3)


def test_rows_are_linear_in_the_environment(make: Make) -> None:
    product = make(window_room())
    studio = product.relight(sky(map="studio")).image
    assert studio.mean() > 0.01
    thrice = product.relight(sky(map="studio", intensity=3)).image
    np.testing.assert_allclose(thrice, 3 * studio, rtol=1e-4, atol=1e-5)
    red, rest, both = (
        product.relight(sky(map=m)).image for m in ([1, 0, 0], [0, 0.5, 2], [1, 0.5, 2])
    )
    np.testing.assert_allclose(red + rest, both, rtol=1e-5, atol=1e-6)


def test_a_whole_turn_changes_nothing_and_a_half_turn_does(make: Make) -> None:
    product = make(window_room())
    still = product.relight(sky(map="studio", rotation_degrees=30)).image
    whole = product.relight(sky(map="studio", rotation_degrees=390)).image
    half = product.relight(sky(map="studio", rotation_degrees=210)).image
    assert still.tobytes() == whole.tobytes()
    assert np.abs(half - still).mean() > 0.1 * still.mean()
    assert product.relight(sky(map="studio", rotation_degrees=30)).image.tobytes() == (
        still.tobytes()
    )


def test_the_background_is_the_map_itself(make: Make) -> None:
    """Where the camera looks out of the window, exactly; whatever the edit before was."""
    room = window_room(48)
    product = make(room)
    hits = product.view.buffer.centre.model >= 0
    inside = ~hits
    inside[product.view.buffer.edge] = False
    assert inside.sum() > 30
    for fields in ({"map": "studio"}, {"map": "studio", "rotation_degrees": 77, "intensity": 2}):
        image = product.relight(sky(**fields)).image.reshape(-1, 3)
        environment = apply(room, sky(**fields)).environment
        assert environment is not None
        away = places_on_map(-product.view.buffer.centre.view[inside])
        np.testing.assert_array_equal(image[inside], seen_radiance(environment, away))
    half = product.relight(sky(**fields), 2).image
    np.testing.assert_array_equal(
        half.reshape(-1, 3)[inside.reshape(48, 64)[::2, ::2].ravel()],
        image.reshape(48, 64, 3)[::2, ::2][inside.reshape(48, 64)[::2, ::2]],
    )


def test_lights_and_environment_add_up(make: Make) -> None:
    """A lamp in the room and the sky outside: together what each gives alone."""
    room = window_room().with_lights((POINT_LIGHT,))
    product = make(room)
    off = {"id": "point", "enabled": False}
    lamp = product.relight(sky(intensity=0)).image
    outside = product.relight(Edits(lights=[off])).image
    both = product.relight(Edits()).image
    np.testing.assert_allclose(lamp + outside, both, rtol=1e-4, atol=1e-5)
    # The picture of the environment is kept while a light moves, and comes back as it was.
    product.relight(Edits(lights=[{"id": "point", "position": [0.5, 1, 0.5]}]))
    assert product.relight(Edits()).image.tobytes() == both.tobytes()


POINT_LIGHT = white_room(0.5, [{**POINT, "position": [0.2, 1.4, 0.1]}]).lights[0]


# Against the reference


def off_by(image: NDArray[np.float32], truth: Any, mask: NDArray[np.bool_]) -> tuple[float, float]:
    """Relative L2 error with the reference's own noise taken out of it, and that noise."""
    true, variance = truth.image[mask].astype(np.float64), truth.variance[mask]
    signal = (true**2).sum() - variance.sum()
    noise = variance.sum() / signal
    error = ((image[mask] - true) ** 2).sum() / signal
    return float(np.sqrt(max(0.0, error - noise))), float(np.sqrt(noise))


def surfaces(product: Transfer) -> NDArray[np.bool_]:
    """(h, w) bool: pixels of surfaces away from edges."""
    seen = product.view.buffer.centre.model.reshape(product.view.shape(1)) >= 0
    return seen & ~scene_edges(product.view.scene)


@pytest.mark.parametrize(
    ("fields", "most"),
    [
        pytest.param({"map": [1, 0.9, 0.8]}, 0.03, marks=pytest.mark.sweep),
        ({"map": CLEAR_SKY, "rotation_degrees": 200}, 0.03),
    ],
    ids=["even", "clear sky"],
)
def test_a_room_lit_through_its_window_agrees_with_the_reference(
    make: Make, fields: dict[str, Any], most: float
) -> None:
    room = window_room(24)
    product = make(room, gather_samples=4096)
    truth = render(apply(room, sky(**fields)), samples=4096)
    error, noise = off_by(product.relight(sky(**fields)).image, truth, surfaces(product))
    assert noise < 0.08
    assert error < most, f"{error:.3f} off beyond the reference's noise of {noise:.3f}"


def test_metal_reflects_the_edited_environment(make: Make) -> None:
    """A ball of rough metal in the open: its highlights turn with the map."""
    ball = scene(
        camera=camera(32, position=[0, 0, 4], fov_y_degrees=30),
        materials={
            "brass": {
                "type": "ggx",
                "diffuse": [0] * 3,
                "specular": [0.8, 0.6, 0.3],
                "roughness": 0.4,
            }
        },
        objects=[{"name": "ball", "mesh": {"shape": "sphere", "radius": 0.9}, "material": "brass"}],
    )
    product = make(ball, gloss_coefficients=1000)
    images = []
    for turn in (0, 130):
        edit = sky(map="studio", rotation_degrees=turn)
        truth = render(apply(ball, edit), samples=1024)
        images.append(product.relight(edit).image)
        error, noise = off_by(images[-1], truth, surfaces(product))
        assert noise < 0.05
        # With 300 coefficients 0.046, most of it the noise of the reference.
        assert error < 0.04, f"{error:.3f} off, noise {noise:.3f}, turned by {turn}"
    lit = surfaces(product)
    assert np.abs(images[1] - images[0])[lit].mean() > 0.2 * images[0][lit].mean()


# What is not there costs nothing


def test_a_closed_room_has_no_rows_and_does_not_see_the_sky(make: Make) -> None:
    product = make(white_room(0.5, [POINT]))
    assert sum(array.nbytes for rows in product.environment for array in rows[1:]) == 0
    dark, lit = product.relight(Edits()), product.relight(sky(map=[5, 5, 5]))
    np.testing.assert_array_equal(dark.image, lit.image)


def test_without_an_environment_no_row_is_read(make: Make) -> None:
    """And one can be brought in by an edit, as the box is open towards the camera."""
    product = make(cornell(32))
    bare = product.relight(Edits())
    assert not any(name.startswith("environment") for name in bare.timings)
    lit = product.relight(sky(map="studio"))
    assert lit.image.mean() > bare.image.mean() + 0.01
    assert product.relight(Edits()).image.tobytes() == bare.image.tobytes()


def lamps(count: int) -> NDArray[np.float32]:
    """A dim map with small bright lamps in a row."""
    image = np.full((128, 256, 3), 0.1, np.float32)
    for k in range(count):
        image[30:32, 20 + 20 * k : 22 + 20 * k] = 2000 / count
    return image


def test_a_sun_in_a_map_casts_a_shadow(make: Make, tmp_path: Path) -> None:
    """Of a block on a floor, as sharp as the reference's, and turns with the map."""
    write_image(tmp_path / "sun.exr", lamps(1))
    yard = scene(
        camera=camera(32, position=[0, 3, 3], target=[0, 0.2, 0], fov_y_degrees=45),
        materials={"stone": {"type": "diffuse", "diffuse": [0.6] * 3}},
        objects=[
            {**rectangle("floor", [9, 9], [0, 0, 0], [-90, 0, 0]), "material": "stone"},
            {
                "name": "block",
                "mesh": {"shape": "box", "size": [0.5, 1, 0.5]},
                "material": "stone",
                "transform": {"translate": [0, 0.5, 0]},
            },
        ],
    )
    yard = replace(yard, folder=str(tmp_path))
    product = make(yard)
    for turn in (0, 100):
        edit = sky(map="sun.exr", rotation_degrees=turn)
        frame = product.relight(edit)
        truth = render(apply(yard, edit), samples=256)
        error, noise = off_by(frame.image, truth, surfaces(product))
        assert noise < 0.1
        assert error < 0.05, f"{error:.3f} off, noise {noise:.3f}, turned by {turn}"
        assert not [w for w in frame.warnings if w.code == "environment_too_sharp"]


def test_lamps_in_a_map_that_are_too_many_are_said(make: Make, tmp_path: Path) -> None:
    """Maps without any, and the same where nobody sees the sky, are not."""
    write_image(tmp_path / "lamps.exr", lamps(8))
    for room, told in ((floor(), True), (white_room(0.5, [POINT]), False)):
        room = replace(room, folder=str(tmp_path))
        product = make(room)
        frame = product.relight(sky(map="lamps.exr"))
        found = [w for w in frame.warnings if w.code == "environment_too_sharp"]
        assert bool(found) == told
        for fields in ({"map": "studio"}, {"map": CLEAR_SKY}, {"map": [0, 0, 0]}):
            codes = [w.code for w in product.relight(sky(**fields)).warnings]
            assert "environment_too_sharp" not in codes
        if told:
            assert "type sun" in found[0].message
            true = render(apply(room, sky(map="lamps.exr")), samples=64)
            wrong = off_by(frame.image, true, surfaces(product))[0]
            assert wrong / 2 < found[0].size < 2 * wrong


@pytest.mark.sweep
def test_the_living_room_is_lit_through_its_windows(make: Make, shared_data: Path) -> None:
    """What comes straight from a real map into a real room, on the whole; its lamps are off."""
    room = open_scene(shared_data / "scenes" / "living_room" / "living_room.obj")
    size = {"width": 48, "height": 36}
    room = room.with_camera(edited_camera(room.camera, size)).with_lights(())
    room = apply(room, Edits(materials={n: {"emission": [0, 0, 0]} for n in room.material_names}))
    edit = sky(map=str(shared_data / "envmaps" / "venice.exr"), rotation_degrees=40)
    # The usual 100 coefficients are 2.9 % too bright on the whole at this size, by 4,096 samples of
    # the reference; these 0.1 % too dark. With so few samples it is off by 2 % itself.
    product = make(room, gather_samples=4096, coefficients=1000)
    truth = render(apply(room, edit), samples=512)
    lit = surfaces(product)
    direct = product.relight(edit).image - product.indirect(edit)
    assert direct[lit].mean() == pytest.approx(truth.direct[lit].mean(), rel=0.04)
    # The reference's own noise is a third of each pixel, so they are compared in groups.
    ours, true = (np.where(lit[..., None], a, 0)[:36, :48] for a in (direct, truth.direct))
    ours, true = (a.reshape(6, 6, 6, 8, 3).sum(axis=(1, 3)) for a in (ours, true))
    assert np.linalg.norm(ours - true) < 0.1 * np.linalg.norm(true)


def test_the_transport_does_not_depend_on_the_environment() -> None:
    room = window_room()
    for fields in ({"map": "studio"}, {"intensity": 0}, {"rotation_degrees": 10}):
        lit = apply(room, sky(**fields))
        for part in NEEDS:
            assert key(lit, Settings(), part) == key(room, Settings(), part)


def test_the_preview_takes_the_same_edits(make: Make) -> None:
    """Noisy, but the same light on the whole, and the same background."""
    room = window_room(48)
    preview, product = DirectPreview(room), make(room)
    edit = sky(map="studio", rotation_degrees=200)
    seen = product.view.buffer.centre.model >= 0
    seen[product.view.buffer.edge] = True
    for scale in (1, 2):
        quick, whole = preview.relight(edit, scale).image, product.relight(edit, scale).image
        away = ~seen.reshape(48, 64)[::scale, ::scale]
        np.testing.assert_array_equal(quick[away], whole[away])
    direct = product.relight(edit).image - product.indirect(edit)
    quick = preview.relight(edit).image
    floor = (product.view.buffer.centre.object == 0).reshape(48, 64)
    assert quick[floor].mean() == pytest.approx(direct[floor].mean(), rel=0.05)
