"""Products of awkward scenes, in a store of each module's own."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from engine.methods import prepare
from engine.methods.brdf_editing import Polynomial
from engine.methods.brdf_editing import Settings as EditingSettings
from engine.methods.direct_to_indirect import Settings, Transfer
from engine.scene.scene import Scene
from engine.store import Store


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Transfer]:
    """make(scene, **settings): its product; few gather samples where nothing else is asked."""
    store = Store(tmp_path_factory.mktemp("store"))

    def product(scene: Scene, **settings: object) -> Transfer:
        chosen = Settings(**{"gather_samples": 256, **settings})  # type: ignore[arg-type]
        return prepare(scene, "direct_to_indirect", chosen, store=store)  # type: ignore[return-value]

    return product


@pytest.fixture(scope="module")
def editable(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Polynomial]:
    """editable(scene, **settings): the same of `brdf_editing`."""
    store = Store(tmp_path_factory.mktemp("store"))

    def product(scene: Scene, **settings: object) -> Polynomial:
        chosen = EditingSettings(**{"gather_samples": 1024, **settings})  # type: ignore[arg-type]
        return prepare(scene, "brdf_editing", chosen, store=store)  # type: ignore[return-value]

    return product
