"""What `glossy_prt` says of how well its terms fit the materials."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.scenes import camera, scene

from engine.brdf.factored import Factored
from engine.brdf.fit import rms_errors, uniform_pairs
from engine.methods import prepare
from engine.methods.base import Product
from engine.methods.glossy_prt import Settings
from engine.scene.edits import Edits
from engine.scene.scene import Scene
from engine.store import Store

SMALL = {
    "light_texels": 8,
    "visibility_texels": 8,
    "coarse_texels": 8,
    "bounces": 0,
    "brdf_texels": 24,
}


def balls(**materials: dict[str, Any]) -> Scene:
    """A ball of each material; one material more that nothing is made of."""
    return scene(
        camera=camera(8, position=[0, 0, 4]),
        environment={"map": [1, 1, 1]},
        materials={**materials, "spare": {"type": "phong", "exponent": 500}},
        objects=[
            {"name": name, "mesh": {"shape": "sphere", "radius": 0.4, "rings": 4},
             "material": name, "transform": {"translate": [k, 0, 0]}}
            for k, name in enumerate(materials)
        ],
    )  # fmt: skip


SATIN = {"type": "phong", "diffuse": [0.6, 0.1, 0.1], "specular": [0.2] * 3, "exponent": 4}
MIRROR = {"type": "phong", "diffuse": [0.1] * 3, "specular": [0.7] * 3, "exponent": 300}
CLAY = {"type": "diffuse", "diffuse": [0.4, 0.3, 0.2]}


def made(store: Store, **settings: int) -> Product:
    where = balls(satin=SATIN, mirror=MIRROR, clay=CLAY)
    return prepare(where, "glossy_prt", Settings(**{**SMALL, **settings}), store=store)


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Store:
    return Store(tmp_path_factory.mktemp("store"))


def test_materials_that_are_used_tell_their_terms_and_error(store: Store) -> None:
    fits = {fit.name: fit for fit in made(store).fits}
    assert set(fits) == {"satin", "mirror", "clay"}
    # A coloured material with grey gloss has a term for its colour, and grey transport.
    assert (fits["satin"].terms, fits["satin"].channels) == (5, 1)
    assert (fits["clay"].terms, fits["clay"].channels, fits["clay"].error) == (1, 1, 0)
    assert fits["satin"].error < 0.3
    assert fits["mirror"].error > 0.9


def test_the_error_is_that_of_the_terms_that_are_stored(store: Store) -> None:
    product = made(store)
    (fit,) = (fit for fit in product.fits if fit.name == "satin")
    terms = product.terms[0]  # type: ignore[attr-defined]
    factored = Factored(np.broadcast_to(terms.light, terms.view.shape), terms.view)
    material = product.scene.materials[0]  # type: ignore[attr-defined]
    each, whole = rms_errors(factored, uniform_pairs(material, seed=2))
    assert fit.error == pytest.approx(each[-1] / whole, rel=0.05)


def test_what_is_too_glossy_is_said_in_every_frame(store: Store) -> None:
    product = made(store)
    said = [w for w in product.relight(Edits()).warnings if w.code == "too_glossy_for_terms"]
    assert len(said) == 1
    assert "'mirror'" in said[0].message
    assert "would hold 50 %" in said[0].message
    assert "satin" not in said[0].message
    assert said[0].size > 0.9


def test_of_several_that_are_too_glossy_the_worst_is_told(store: Store) -> None:
    chrome = {**MIRROR, "diffuse": [0, 0, 0]}
    where = balls(mirror=MIRROR, chrome=chrome, clay=CLAY)
    product = prepare(where, "glossy_prt", Settings(**SMALL), store=store)
    warnings = product.relight(Edits()).warnings
    (said,) = (w for w in warnings if w.code == "too_glossy_for_terms")
    assert said.message.startswith("Material 'chrome' is")
    assert said.message.endswith("Too glossy as well: 'mirror'.")


def test_more_terms_fit_better(store: Store) -> None:
    few, many = ({fit.name: fit.error for fit in made(store, terms=k).fits} for k in (2, 16))
    assert many["satin"] < 0.5 * few["satin"]
    assert many["mirror"] < few["mirror"]


def test_fits_come_back_from_the_store(tmp_path: Path) -> None:
    store = Store(tmp_path)
    first, again = made(store), made(store)
    assert again.fits == first.fits
    messages = [[w.message for w in p.relight(Edits()).warnings] for p in (first, again)]
    assert messages[0] == messages[1]
