"""What a product takes later: other settings, other materials, a model under the hand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.methods import METHODS, prepare
from engine.methods.wavelet_brdf import Settings, Wavelets
from engine.scene.edits import Edits
from engine.scene.open import open_scene
from engine.store import Store

SCENE: dict[str, Any] = {
    "camera": {"position": [0, 0, 3], "target": [0, 0, 0], "width": 16, "height": 12},
    "lights": [{"id": "key", "type": "point", "position": [1, 1, 3], "intensity": [20, 20, 20]}],
    "materials": {"ball": {"type": "phong", "diffuse": [0.3, 0.1, 0.1],
                           "specular": [0.2, 0.2, 0.2], "exponent": 10}},
    "objects": [{"name": "ball", "mesh": {"shape": "sphere", "radius": 1, "rings": 8},
                 "material": "ball"}],
}  # fmt: skip
QUICK = Settings(cells=8, error=0.05)
DULL = {"ball": {"exponent": 5}}


@pytest.fixture(scope="module")
def product(tmp_path_factory: pytest.TempPathFactory) -> Wavelets:
    path = tmp_path_factory.mktemp("scene") / "scene.json"
    path.write_text(json.dumps(SCENE))
    store = Store(Path(tmp_path_factory.mktemp("store")))
    made = prepare(open_scene(path), "wavelet_brdf", QUICK, store=store)
    assert isinstance(made, Wavelets)
    return made


def test_other_settings_share_the_codes(product: Wavelets) -> None:
    method = METHODS["wavelet_brdf"]
    assert method.retuned is not None
    wanted = Settings(cells=8, error=0.05, show="levels")
    retuned = method.retuned(product, wanted)
    assert retuned.settings == wanted
    assert (retuned.bytes, retuned.fits) == (product.bytes, product.fits)
    levels = retuned.relight(Edits(), backend="cpu").image[6, 8]
    assert levels.argmax() == 2
    assert product.relight(Edits(), backend="cpu").image[6, 8].argmax() == 0


def test_fits_of_other_materials(product: Wavelets) -> None:
    method = METHODS["wavelet_brdf"]
    assert method.refitted is not None
    assert method.refitted(product, product.scene.materials) == product.fits
    (matt,) = method.refitted(
        product, tuple(m.model_copy(update={"exponent": 3.0}) for m in product.scene.materials)
    )
    assert matt != product.fits[0]
    assert matt.bytes > 0


def test_a_model_under_the_hand_is_drawn_by_its_formula(product: Wavelets) -> None:
    """Quick pictures need no code; the one of a hand that rests has it, as if nothing had been."""
    entries = {path.name for path in product._store.root.rglob("*")}
    quick = product.relight(Edits(materials=DULL), 2, "cpu")
    assert {path.name for path in product._store.root.rglob("*")} == entries
    assert "drawn_by_formula" not in [said.code for said in quick.warnings]
    full = product.relight(Edits(materials=DULL), 1, "cpu")
    again = product.relight(Edits(materials=DULL), 2, "cpu")
    # A formula and its code are alike, and not the same.
    np.testing.assert_allclose(quick.image, again.image, atol=0.3 * float(full.image.max()))
    assert not np.array_equal(quick.image, again.image)
    np.testing.assert_array_equal(
        product.relight(Edits(materials=DULL), 1, "cpu").image, full.image
    )
