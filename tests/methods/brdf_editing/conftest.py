"""What tests of `brdf_editing` share."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

from engine.methods import prepare
from engine.methods.brdf_editing import Polynomial, Settings
from engine.scene.scene import Scene
from engine.store import Store


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Polynomial]:
    """make(scene, **settings): its product, in a store of this module's own."""
    store = Store(tmp_path_factory.mktemp("store"))

    def product(of: Scene, **settings: Any) -> Polynomial:
        fields = {"gather_samples": 1024, "view_rays": 512, **settings}
        return prepare(of, "brdf_editing", Settings(**fields), store=store)  # type: ignore[return-value]

    return product
