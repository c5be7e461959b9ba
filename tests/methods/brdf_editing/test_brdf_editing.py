"""`brdf_editing`: frames are the polynomial, the polynomial is the light."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from methods.scenes import POINT, camera, rectangle, scene
from numpy.typing import NDArray

from engine.errors import Cancelled, EditNotSupported
from engine.measure.edges import scene_edges
from engine.methods import prepare
from engine.methods.brdf_editing import Polynomial
from engine.methods.interrupt import interruptible
from engine.reference import render
from engine.scene.edits import Edits, apply
from engine.scene.scene import Scene
from engine.store import Store

Make = Callable[..., Polynomial]
GLOSSY = {"type": "blinn_phong", "diffuse": [0.3] * 3, "specular": [0.3] * 3, "exponent": 40}
LAMP = {
    "id": "lamp", "type": "area", "position": [0, 0.95, 0], "target": [0, 0, 0], "up": [0, 0, 1],
    "width": 0.5, "height": 0.5, "intensity": [8, 7, 6],
}  # fmt: skip


def corner(**fields: Any) -> Scene:
    """Two walls, a floor and a ball on it, open to the front."""
    sides = [
        ("floor", [0, -1, 0], [-90, 0, 0]),
        ("left", [-1, 0, 0], [0, 90, 0]),
        ("back", [0, 0, -1], [0, 0, 0]),
    ]
    walls = [{**rectangle(name, [2, 2], *at), "material": name} for name, *at in sides]
    ball = {
        "name": "ball",
        "mesh": {"shape": "sphere", "radius": 0.4, "rings": 32},
        "transform": {"translate": [0.2, -0.6, -0.2]},
        "material": "ball",
    }
    matt = {"type": "diffuse", "diffuse": [0.6, 0.6, 0.6]}
    return scene(
        **{
            "camera": camera(48, position=[0.4, 0.3, 1.9], target=[0, -0.4, 0], fov_y_degrees=50),
            "lights": [POINT, LAMP],
            "materials": {
                "floor": GLOSSY,
                "left": {"type": "diffuse", "diffuse": [0.7, 0.1, 0.1]},
                "back": matt,
                "ball": {"type": "cook_torrance", "diffuse": [0.1, 0.3, 0.6], "roughness": 0.4},
            },
            "objects": [*walls, ball],
            **fields,
        }
    )


def edit(**materials: Any) -> Edits:
    return Edits(materials=materials)


def off(found: NDArray, true: NDArray) -> float:
    return float(np.linalg.norm(found - true) / np.linalg.norm(true))


def smooth(image: NDArray) -> NDArray:
    """Means of 4 x 4 pixels, which hold less of the reference's noise."""
    height, width = image.shape[:2]
    return image.reshape(height // 4, 4, width // 4, 4, 3).mean(axis=(1, 3))


EDITS = [
    edit(),
    edit(left={"diffuse": [0.1, 0.2, 0.9]}),
    edit(floor={"exponent": 200, "specular": [0.5, 0.4, 0.3]}),
    edit(ball={"roughness": 0.25, "specular": [0.8, 0.6, 0.3], "diffuse": [0, 0, 0]}),
    edit(back={"type": "ggx", "diffuse": [0.2, 0.2, 0.2], "roughness": 0.5}),
]


@pytest.mark.parametrize("edits", EDITS, ids=range(len(EDITS)))
def test_frames_are_what_the_reference_sees(make: Make, edits: Edits) -> None:
    made = corner()
    found = make(made).relight(edits).image
    true = render(apply(made, edits), samples=256, max_bounces=4)
    kept = ~scene_edges(made)[..., None]
    assert off(smooth(found * kept), smooth(true.image * kept)) < 0.04


# A curve as a hand draws it: a highlight, and a ring of facets that are 15 degrees steep.
DRAWN = (90.0, 90.0, 85.0, 60.0, 25.0, 6.0, 1.5, 0.5, 4.0, 9.0, 4.0, 0.3, *[0.05] * 10)
CURVED = {"type": "half_angle_curve", "diffuse": [0.1, 0.1, 0.2], "specular": [0.6, 0.5, 0.4]}


def test_a_curve_under_the_hand(make: Make) -> None:
    """Its points are dragged in one hand, to what the reference sees."""
    made = corner()
    product = make(made)
    product.relight(edit(floor=CURVED))
    hand = product._hand
    edits = edit(floor={**CURVED, "curve": DRAWN})
    found = product.relight(edits).image
    assert product._hand is hand
    true = render(apply(made, edits), samples=256, max_bounces=4)
    kept = ~scene_edges(made)[..., None]
    assert off(smooth(found * kept), smooth(true.image * kept)) < 0.04
    flat = product.relight(edit(floor=CURVED)).image
    assert off(smooth(flat * kept), smooth(true.image * kept)) > 0.08


def test_a_brushed_grain_is_dragged_in_one_hand(make: Make) -> None:
    """The exponent across the grain, and so the ratio of eq. 33; along it is another hand."""
    brushed = {"type": "ashikhmin_shirley", "specular": [0.6, 0.6, 0.5], "diffuse": [0.1, 0.1, 0.2]}
    made = corner(
        materials={
            "floor": {**brushed, "exponent_u": 10, "exponent_v": 60},
            "left": {"type": "diffuse", "diffuse": [0.7, 0.1, 0.1]},
            "back": {"type": "diffuse", "diffuse": [0.6, 0.6, 0.6]},
            "ball": {"type": "cook_torrance"},
        }
    )
    product = make(made)
    product.relight(edit())
    product.relight(edit(floor={"exponent_v": 50}))
    hand = product._hand
    edits = edit(floor={"exponent_v": 4})
    found = product.relight(edits).image
    assert product._hand is hand
    true = render(apply(made, edits), samples=256, max_bounces=4)
    kept = ~scene_edges(made)[..., None]
    assert off(smooth(found * kept), smooth(true.image * kept)) < 0.04
    product.relight(edit(floor={"exponent_u": 60, "exponent_v": 4}))
    along = product._hand
    assert along is not hand
    product.relight(edit(floor={"exponent_u": 30, "exponent_v": 4}))
    assert product._hand is along


def test_a_curve_that_is_too_much_is_no_brighter_than_all_there_is(make: Make) -> None:
    """White all about and white curves, every node ten times too high: no more light than comes."""
    white = {"type": "half_angle_curve", "diffuse": [1, 1, 1], "specular": [1, 1, 1]}
    every = {name: {**white, "curve": [10.0] * 22} for name in ("floor", "left", "back", "ball")}
    made = corner(environment={"map": [1, 1, 1]}, lights=[])
    found = make(made, bounces=8).relight(edit(**every)).image
    assert smooth(found).max() < 1.02


def test_under_an_environment(make: Make) -> None:
    made = corner(environment={"map": "studio"}, lights=[])
    edits = edit(ball={"specular": [0.7, 0.7, 0.7], "roughness": 0.3})
    found = make(made).relight(edits).image
    true = render(apply(made, edits), samples=512, max_bounces=4)
    kept = ~scene_edges(made)[..., None]
    assert off(smooth(found * kept), smooth(true.image * kept)) < 0.06


@pytest.mark.parametrize("name", ["floor", "left", "ball"])
def test_the_polynomial_is_what_a_fresh_freeze_gives(make: Make, name: str) -> None:
    """Taken in hand dark and matt, then edited, or taken in hand as it is: the same picture."""
    made, last = corner(), {"floor": EDITS[2], "left": EDITS[1], "ball": EDITS[3]}[name]
    product = make(made)
    product.relight(edit(**{name: {"diffuse": [0.01, 0.01, 0.01]}}))
    dragged = product.relight(last).image
    assert product._hand is not None
    product._hand = None
    product.relight(edit(back={"diffuse": [0.5, 0.6, 0.6]}))
    back = {"back": {"diffuse": [0.6, 0.6, 0.6001]}}
    frozen = product.relight(Edits(materials={**(last.materials or {}), **back})).image
    assert off(dragged, frozen) < 2e-3


def test_a_material_is_taken_in_hand_before_it_changes(make: Make) -> None:
    """By a frame that names it last; where nothing else is named, nothing is taken."""
    made = corner()
    product, names = make(made), made.material_names

    def hand_after(*edits: Edits) -> Any:
        for each in edits:
            product.relight(each)
        assert product._hand is not None
        return product._hand

    red = {"diffuse": [0.7, 0.1, 0.2]}
    assert hand_after(edit(left=red)).material == names.index("left")
    taken = hand_after(edit(left=red, back={}))
    assert taken.material == names.index("back")
    assert hand_after(edit(left=red, back={"diffuse": [0.1, 0.1, 0.1]})) is taken
    # Who names them in the same order always, and goes on with the first, is not hindered.
    other = {"diffuse": [0.6, 0.1, 0.2]}
    first = hand_after(edit(left=other, back={}))
    assert first.material == names.index("left")
    assert hand_after(*[edit(left=other, back={})] * 2, edit(left=red, back={})) is first


def test_a_whole_picture_stops_when_nobody_waits_and_the_small_one_is_there(make: Make) -> None:
    product = make(corner())
    blue, red = edit(left={"diffuse": [0.1, 0.2, 0.9]}), edit(left={"diffuse": [0.9, 0.2, 0.1]})
    small = product.relight(blue, scale=2).image
    hand = product._hand
    with interruptible(lambda: True), pytest.raises(Cancelled):
        product.relight(blue)
    assert product._hand is hand
    np.testing.assert_array_equal(product.relight(blue, scale=2).image, small)
    # One that stops in the middle leaves nothing behind.
    asked = iter([False, True])
    with interruptible(lambda: next(asked)), pytest.raises(Cancelled):
        product.relight(edit(floor={"exponent": 50}))
    found = product.relight(red).image
    np.testing.assert_array_equal(found, make(corner()).relight(red).image)


def test_a_drag_there_and_back_returns_the_same_bits(make: Make) -> None:
    product = make(corner())
    here = edit(floor={"exponent": 40.5})
    before = product.relight(here).image
    hand = product._hand
    for exponent, colour in ((0, [0, 0, 0]), (5000, [1, 1, 1])):
        product.relight(edit(floor={"exponent": exponent, "diffuse": colour}))
    assert product._hand is hand
    np.testing.assert_array_equal(product.relight(here).image, before)


def test_black_is_a_colour_like_any_other(make: Make) -> None:
    """Nothing is divided by an albedo: black when taken in hand, then white."""
    made = corner()
    product = make(made)
    black = {"diffuse": [0, 0, 0], "specular": [0, 0, 0]}
    dark = product.relight(edit(floor=black)).image
    light = product.relight(edit(floor={**black, "diffuse": [0.6, 0.6, 0.6]})).image
    assert np.isfinite(dark).all()
    true = make(made).relight(edit(floor={**black, "diffuse": [0.6, 0.6, 0.6]})).image
    assert off(light, true) < 2e-3
    assert light.mean() > 1.2 * dark.mean()


def test_linear_in_the_light(make: Make) -> None:
    """Twice the light is twice the picture, but for what the camera sees of the lamp."""
    made = corner()
    bright = made.with_lights(
        tuple(light.model_copy(update={"intensity": (4.0, 2.0, 1.0)}) for light in made.lights[:1])
    )
    dim = made.with_lights(
        tuple(light.model_copy(update={"intensity": (2.0, 1.0, 0.5)}) for light in made.lights[:1])
    )
    np.testing.assert_allclose(
        make(bright).relight(EDITS[2]).image, 2 * make(dim).relight(EDITS[2]).image, rtol=2e-3,
        atol=1e-5,
    )  # fmt: skip


def test_boxes_are_the_papers_and_coarser(make: Make) -> None:
    made, edits = corner(), edit(ball={"roughness": 0.15, "specular": [0.9, 0.9, 0.9]})
    exact = make(made, bands=512).relight(edits).image
    tents, boxes = (
        off(make(made, bands=16, basis=basis).relight(edits).image, exact)
        for basis in ("tents", "boxes")
    )
    assert tents < 0.5 * boxes
    assert boxes == pytest.approx(0.10, abs=0.03)


@pytest.mark.parametrize(
    ("edits", "field"),
    [
        (Edits(camera={"fov_y_degrees": 30}), "camera"),
        (edit(left={"emission": [1, 1, 1]}), "materials.left.emission"),
        (edit(left={"type": "lafortune"}), "materials.left"),
        (edit(left={"type": "ashikhmin_shirley"}), "materials.left.type"),
    ],
)
def test_what_it_cannot_take(make: Make, edits: Edits, field: str) -> None:
    with pytest.raises(EditNotSupported) as error:
        make(corner()).relight(edits)
    assert error.value.field == field


def test_every_second_pixel(make: Make) -> None:
    product = make(corner())
    whole, half = product.relight(EDITS[2]).image, product.relight(EDITS[2], scale=2).image
    assert half.shape == (24, 24, 3)
    lamp = whole[::2, ::2].max(axis=-1) > 5
    np.testing.assert_allclose(half[~lamp], whole[::2, ::2][~lamp], rtol=1e-5)


def test_a_second_product_is_read_from_the_store(make: Make) -> None:
    made = corner()
    first = make(made)
    phases: list[str] = []
    again = prepare(
        made, "brdf_editing", first.settings, lambda phase, done, total: phases.append(phase),
        store=Store(make.__closure__[0].cell_contents.root),  # type: ignore[index]
    )  # fmt: skip
    assert set(phases) == {"view samples"}
    np.testing.assert_array_equal(again.relight(EDITS[2]).image, make(made).relight(EDITS[2]).image)
    other = replace(first.settings, bands=32, bounces=1)
    assert prepare(made, "brdf_editing", other).settings.bounces == 1


def test_a_roughness_that_quotients_know_is_followed_while_the_hand_moves(make: Make) -> None:
    """In small pictures by the hand that is there, nearly; in whole ones by one of its own."""
    made = corner()
    rough = [edit(floor={"type": "ggx", "specular": [0.6] * 3, "roughness": r}) for r in (0.4, 0.5)]
    product = make(made)
    product.relight(rough[0])
    hand = product._hand
    moving = product.relight(rough[1], scale=2).image
    assert product._hand is hand
    at_rest = product.relight(rough[1]).image
    assert product._hand is not hand
    np.testing.assert_array_equal(at_rest, make(made).relight(rough[1]).image)
    whole = at_rest[::2, ::2]
    before = make(made).relight(rough[0]).image[::2, ::2]
    assert off(moving, whole) < 0.2 * off(before, whole)
    far = edit(floor={"type": "ggx", "specular": [0.6] * 3, "roughness": 0.8})
    product.relight(far, scale=2)
    assert product._hand is not None
    assert product._hand.scale == 2
