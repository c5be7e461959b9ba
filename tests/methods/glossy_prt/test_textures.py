"""Reflectances that vary over a surface, in the picture and in what bounces."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.scenes import camera, rectangle
from PIL import Image

from engine.measure.edges import scene_edges
from engine.methods import prepare
from engine.methods.glossy_prt import Prt, Settings
from engine.reference import render
from engine.scene.build import build
from engine.scene.edits import Edits
from engine.scene.open import describe
from engine.scene.scene import Scene
from engine.store import Store

Make = Callable[..., Prt]
PHONG = {"type": "phong", "diffuse": [0.2, 0.3, 0.1], "specular": [0.4] * 3, "exponent": 6}
FEW = {"light_texels": 16, "visibility_texels": 16, "brdf_texels": 24, "bounces": 0}
GGX = {"type": "ggx", "diffuse": [0.5] * 3, "specular": [0.04] * 3, "roughness": 0.5}


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Make:
    """make(scene, **settings): its product, in a store of this module's own."""
    store = Store(tmp_path_factory.mktemp("store"))

    def product(of: Scene, **settings: Any) -> Prt:
        chosen = {**FEW, **settings}
        return prepare(of, "glossy_prt", Settings(**chosen), store=store)  # type: ignore[return-value]

    return product


def corner(folder: Path, material: dict[str, Any]) -> Scene:
    """A wall of the material on a floor of it, in the studio."""
    floor = rectangle("floor", [2, 2], [0, -0.5, 0], [-90, 0, 0])
    wall = rectangle("wall", [2, 2], [0, 0.5, -1])
    for each in (floor, wall):
        each["mesh"]["segments"] = [16, 16]
    document = {
        "camera": camera(48, position=[0.5, 0.9, 2.2], target=[0, 0, -0.4], fov_y_degrees=45),
        "environment": {"map": "studio"},
        "lights": [],
        "materials": {"gloss": material},
        "objects": [{**floor, "material": "gloss"}, {**wall, "material": "gloss"}],
    }
    return build(describe(document), folder)


def stripes(folder: Path) -> dict[str, Any]:
    """Broad ones of two colours, scaled."""
    image = np.zeros((4, 4, 3), np.uint8)
    image[:, :2], image[:, 2:] = (250, 90, 60), (40, 160, 250)
    Image.fromarray(image).save(folder / "stripes.png")
    return {"texture": "stripes.png", "factor": [0.7, 0.6, 0.5]}


def codes(product: Prt) -> set[str]:
    return {w.code for w in product.relight(Edits()).warnings}


@pytest.mark.parametrize("bounces", [0, 1])
def test_an_even_texture_is_a_number(make: Make, tmp_path: Path, bounces: int) -> None:
    """An image of one colour does what the colour does, in the gloss as in the base."""
    Image.fromarray(np.full((2, 2, 3), 188, np.uint8)).save(tmp_path / "even.png")
    half = ((188 / 255 + 0.055) / 1.055) ** 2.4
    texture = {"texture": "even.png", "factor": [0.8, 0.4, 0.2]}
    plain = [half * f for f in texture["factor"]]
    for varies in (["specular"], ["diffuse", "specular"]):
        textured, even = (
            make(corner(tmp_path, {**PHONG, **dict.fromkeys(varies, value)}), bounces=bounces)
            for value in (texture, plain)
        )
        found, expected = (product.relight(Edits()).image for product in (textured, even))
        assert np.linalg.norm(found - expected) < 0.02 * np.linalg.norm(expected)
        assert "textures_left_out" not in codes(textured)


def test_agrees_with_the_reference(make: Make, tmp_path: Path) -> None:
    """Stripes of gloss and of the base, with the light that bounces between them."""
    texture = stripes(tmp_path)
    made = corner(tmp_path, {**PHONG, "diffuse": texture, "specular": texture})
    finer = {"light_texels": 64, "visibility_texels": 128, "brdf_texels": 48}
    found = make(made, bounces=1, terms=8, **finer)
    true = render(made, samples=256, max_bounces=2)
    kept = ~scene_edges(made)
    noise = np.sqrt(true.variance[kept].sum()) / np.linalg.norm(true.image[kept])
    off = found.relight(Edits()).image - true.image
    assert np.linalg.norm(off[kept]) < (0.05 + noise) * np.linalg.norm(true.image[kept])


@pytest.mark.parametrize(
    ("material", "field"), [(GGX, "specular"), (GGX, "roughness"), (PHONG, "normal")]
)
def test_what_is_left_out_is_said(
    make: Make, tmp_path: Path, material: dict[str, Any], field: str
) -> None:
    stripes(tmp_path)
    texture: dict[str, Any] = {"texture": "stripes.png"}
    if field in material:
        texture["factor"] = material[field]
    assert "textures_left_out" in codes(make(corner(tmp_path, {**material, field: texture})))
