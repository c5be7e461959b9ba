"""Products of small codes, in a store of each module's own."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest

from engine.brdf import measured
from engine.brdf.wavelet.encoding import DEFAULT
from engine.methods import prepare
from engine.methods.wavelet_brdf import Settings, Wavelets
from engine.scene.scene import Scene
from engine.store import Store

BITS = 3


@pytest.fixture(scope="module")
def make(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Wavelets]:
    """make(scene, **settings): its product, of 8 cells where nothing else is asked."""
    store = Store(tmp_path_factory.mktemp("store"))

    def product(scene: Scene, **settings: Any) -> Wavelets:
        chosen = Settings(**{"cells": 1 << BITS, "detail": "finest", **settings})
        return prepare(scene, "wavelet_brdf", chosen, store=store)  # type: ignore[return-value]

    return product


@pytest.fixture(scope="module")
def small_codes() -> Iterator[None]:
    """Materials of scenes have codes of 8 cells too."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(measured.encoded, "__defaults__", (BITS, DEFAULT))
        yield
