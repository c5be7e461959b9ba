"""Textures of a material that is edited: which of them stay, and what is said of the others."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.scenes import POINT, camera, rectangle
from stability.halls import GREY, Editable, edit, gloss, hall, message, off

from engine.errors import EditError
from engine.images import write_image
from engine.scene.build import build
from engine.scene.open import describe
from engine.scene.scene import Scene


def spotted(folder: Path, wall: dict[str, Any]) -> Scene:
    """A textured floor, and a wall that may have the same texture."""
    write_image(folder / "spots.png", np.linspace(0.2, 1, 48).reshape(4, 4, 3).astype(np.float32))
    document = {
        "camera": camera(32),
        "lights": [POINT],
        "materials": {
            "wall": wall,
            "floor": {"type": "diffuse", "diffuse": {"texture": "spots.png"}},
        },
        "objects": [
            {**rectangle("wall", [2, 2], [0, 0, -0.5]), "material": "wall"},
            {**rectangle("floor", [2, 2], [0, -0.5, 0], [-90, 0, 0]), "material": "floor"},
        ],
    }
    return build(describe(document), folder)


@pytest.mark.parametrize(
    "wall",
    [
        gloss(40, 0.2),
        {"type": "ggx", "diffuse": [0] * 3, "roughness": 0.5},
        {"type": "cook_torrance", "diffuse": [0] * 3, "roughness": 0.4},
    ],
    ids=lambda wall: wall["type"],
)
def test_textures_of_specular_reflectance_stay_in_hand(
    editable: Editable, tmp_path: Path, wall: dict[str, Any]
) -> None:
    """A picture is the same whether the wall is in hand or not, and another without its texture."""
    spots = {"texture": "spots.png", "factor": [0.9, 0.8, 0.5]}
    product = editable(spotted(tmp_path, {**wall, "specular": spots}))
    dimmer = {"specular": [0.5, 0.6, 0.4]}
    product.relight(edit(wall={"specular": [0.9, 0.8, 0.6]}))
    in_hand = product.relight(edit(wall=dimmer))
    assert in_hand.warnings == ()
    product.relight(edit(wall=dimmer, floor={"diffuse": [0.5] * 3}))
    frozen = product.relight(edit(wall=dimmer, floor={})).image
    assert off(in_hand.image, frozen) < 2e-3
    plain = editable(spotted(tmp_path, {**wall, "specular": [0.9, 0.8, 0.5]}))
    assert off(plain.relight(edit(wall=dimmer)).image, in_hand.image) > 0.1


def test_textures_of_roughness_are_said_to_be_left_out(editable: Editable, tmp_path: Path) -> None:
    """While their material is in hand, and not otherwise."""
    rough = {"type": "ggx", "diffuse": [0.2] * 3, "roughness": {"texture": "spots.png"}}
    product = editable(spotted(tmp_path, rough))
    wall = product.relight(edit(wall={"specular": [0.5] * 3}))
    assert "'wall' is in hand its roughness stays" in message(wall, "textures_left_out")
    on_floor = product.relight(edit(wall={"specular": [0.5] * 3}, floor={"diffuse": [0.5] * 3}))
    assert [w for w in on_floor.warnings if w.code == "textures_left_out"] == []
    coated = {**rough, "roughness": 0.4, "specular": {"texture": "spots.png"}}
    wall = editable(spotted(tmp_path, coated)).relight(edit(wall={"specular": [0.5] * 3}))
    assert "what its gloss leaves to its base" in message(wall, "textures_left_out")


def test_edits_bring_no_new_textures(editable: Editable) -> None:
    with pytest.raises(EditError, match="constants only, not textures") as error:
        editable(hall(GREY, GREY, [POINT])).relight(edit(floor={"diffuse": {"texture": "new.png"}}))
    assert error.value.field == "materials.floor.diffuse"
