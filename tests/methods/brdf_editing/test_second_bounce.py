"""`brdf_editing` with gloss behind the first bounce: series such as (64, 16) (§4.3)."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import pytest
from methods.brdf_editing.test_brdf_editing import Make, edit, off, smooth
from methods.scenes import camera, rectangle, scene

from engine.errors import InputError
from engine.methods.brdf_editing import Settings
from engine.reference import render
from engine.scene.edits import apply
from engine.scene.scene import Scene

MATT = {"type": "diffuse", "diffuse": [0.6, 0.6, 0.6]}
METAL = {"type": "ggx", "diffuse": [0, 0, 0], "specular": [0.9, 0.7, 0.4], "roughness": 0.35}
SUN = {"id": "sun", "type": "sun", "direction": [0.6, -1, 0], "diameter_degrees": 4,
       "intensity": [3, 3, 3]}  # fmt: skip


@pytest.fixture(scope="module")
def make(make: Make) -> Make:
    """That of all, with settings for two bounces."""
    return partial(make, gather_samples=4096, view_rays=1024, bounces=1)


def mirror(**fields: Any) -> Scene:
    """A matt floor, and a metal wall that throws the sun back onto it; a glossy wall beside."""
    walls = [
        ("floor", "floor", [0, 0, 0], [-90, 0, 0]),
        ("metal", "metal", [1, 1, 0], [0, -90, 0]),
        ("side", "side", [0, 1, -1], [0, 0, 0]),
    ]
    return scene(
        **{
            "camera": camera(64, position=[-2.4, 2.2, 2.2], target=[0, 0.3, 0], fov_y_degrees=48),
            "lights": [SUN],
            "materials": {"floor": MATT, "metal": METAL, "side": {**METAL, "roughness": 0.5}},
            "objects": [
                {**rectangle(name, [2, 2], *at), "material": material}
                for name, material, *at in walls
            ],
            **fields,
        }
    )


EDITS = [
    edit(metal={"roughness": 0.25}),
    edit(metal={"roughness": 0.6, "specular": [0.3, 0.6, 0.9]}),
    edit(metal={"type": "blinn_phong", "diffuse": [0.2, 0.2, 0.2], "specular": [0.7, 0.7, 0.7],
                "exponent": 60}),
    edit(floor={"type": "blinn_phong", "diffuse": [0.1, 0.1, 0.1], "specular": [0.6, 0.6, 0.6],
                "exponent": 300}),
    edit(side={"roughness": 0.3}),
]  # fmt: skip


@pytest.mark.parametrize(
    ("environment", "number", "gain"),
    [pytest.param(None, 0, 0.4, marks=pytest.mark.sweep), (None, 3, 1), ("studio", 4, 1)],
)
def test_gloss_seen_in_gloss_is_what_the_reference_sees(
    make: Make, environment: str | None, number: int, gain: float
) -> None:
    """And what the wall throws onto the floor comes from where the sun is mirrored."""
    lit = {"environment": {"map": environment}, "lights": []} if environment else {}
    made, edits = mirror(**lit), EDITS[number]
    true = smooth(render(apply(made, edits), samples=512, max_bounces=2).image)
    matt, glossy = (
        off(smooth(make(made, second_bands=bands).relight(edits).image), true) for bands in (1, 16)
    )
    assert glossy < 0.05
    assert glossy < gain * matt


def test_the_polynomial_is_what_a_fresh_freeze_gives(make: Make) -> None:
    """In hand and edited, or frozen with the same lobe: 64 elements make the same picture."""
    made = mirror()
    product = make(made, second_bands=64, view_rays=128, gather_samples=1024)
    product.relight(edit(metal={"specular": [0.1, 0.1, 0.1], "roughness": 0.35}))
    dragged = product.relight(edit(metal={"specular": [0.8, 0.7, 0.6], "roughness": 0.35})).image
    last = edit(
        metal={"specular": [0.8, 0.7, 0.6], "roughness": 0.35},
        side={"specular": [0.9, 0.7, 0.4001], "roughness": 0.5},
    )
    frozen = product.relight(last).image
    assert off(dragged, frozen) < 0.01


def test_a_drag_there_and_back_returns_the_same_bits(make: Make) -> None:
    product = make(mirror(), second_bands=16)
    before = product.relight(EDITS[0]).image
    hand = product._hand
    product.relight(edit(metal={"roughness": 0.25, "specular": [0, 0, 0]}))
    assert product._hand is hand
    np.testing.assert_array_equal(product.relight(EDITS[0]).image, before)


def test_few_elements_are_refused() -> None:
    with pytest.raises(InputError) as error:
        Settings(second_bands=2)
    assert error.value.field == "second_bands"
