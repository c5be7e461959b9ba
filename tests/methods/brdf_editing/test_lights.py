"""Lights and materials edited in one sitting, past the paper."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from methods.brdf_editing.test_brdf_editing import LAMP, Make, corner, edit, off, smooth
from methods.scenes import POINT

from engine.errors import EditError
from engine.measure.edges import scene_edges
from engine.reference import render
from engine.scene.edits import Edits, apply

MOVED = {"id": POINT["id"], "position": [-0.5, 0.3, 0.6]}
LAMP_MOVED = {"id": LAMP["id"], "position": [0.4, 0.9, -0.3]}
SHINY = {"floor": {"exponent": 200, "specular": [0.5, 0.4, 0.3]}}


def both(lights: list[dict[str, Any]], **materials: Any) -> Edits:
    return Edits(lights=lights, materials=materials or None)


def test_a_moved_light_is_that_of_a_scene_with_it_there(make: Make) -> None:
    made = corner()
    found = make(made).relight(both([MOVED, LAMP_MOVED], **SHINY)).image
    there = apply(made, Edits(lights=[MOVED, LAMP_MOVED]))
    np.testing.assert_allclose(
        found, make(there).relight(edit(**SHINY)).image, rtol=1e-5, atol=1e-6
    )


def test_one_sitting_against_the_reference(make: Make) -> None:
    """A light moves, a material is edited, the light moves again."""
    made = corner()
    product, kept = make(made), ~scene_edges(made)[..., None]
    sitting = [both([LAMP_MOVED]), both([LAMP_MOVED], **SHINY), both([MOVED, LAMP_MOVED], **SHINY)]
    for edits in sitting:
        found = product.relight(edits).image
        true = render(apply(made, edits), samples=256, max_bounces=4).image
        assert off(smooth(found * kept), smooth(true * kept)) < 0.04


def test_there_and_back(make: Make) -> None:
    product = make(corner())
    before = product.relight(edit()).image
    moved = product.relight(both([MOVED])).image
    assert off(moved, before) > 0.1
    np.testing.assert_array_equal(product.relight(edit()).image, before)


def test_small_pictures_while_the_hand_moves(make: Make) -> None:
    """Every second pixel, and a light with extent by fewer points."""
    made = corner()
    whole = make(made).relight(both([MOVED])).image
    assert off(make(made).relight(both([MOVED]), scale=2).image, whole[::2, ::2]) < 0.01
    lamp = make(made).relight(both([LAMP_MOVED])).image[::2, ::2]
    assert off(make(made).relight(both([LAMP_MOVED]), scale=2).image, lamp) < 0.03


def test_another_material_in_a_small_picture(make: Make) -> None:
    product = make(corner())
    product.relight(edit())
    small = product.relight(edit(**SHINY), scale=2).image
    assert product._hand is not None
    assert product._hand.scale == 2
    whole = product.relight(edit(**SHINY)).image
    assert off(small, whole[::2, ::2]) < 0.01
    # A whole picture's hand serves small ones.
    product.relight(edit(floor={**SHINY["floor"], "exponent": 30}), scale=2)
    assert product._hand.scale == 1


def test_off_added_and_unknown(make: Make) -> None:
    product = make(corner())
    names = [POINT["id"], LAMP["id"]]
    dark = product.relight(both([{"id": name, "enabled": False} for name in names])).image
    assert not dark.any()
    added = {**POINT, "id": "another", "position": MOVED["position"]}
    off_but_one = [{"id": name, "enabled": False} for name in names]
    alone = product.relight(both([*off_but_one, added])).image
    moved = product.relight(both([MOVED, {"id": LAMP["id"], "enabled": False}])).image
    np.testing.assert_allclose(alone, moved, rtol=1e-6)
    with pytest.raises(EditError):
        product.relight(both([{"id": "nobody", "intensity": [1, 1, 1]}]))
