"""Codes are made once, stored, and read back byte for byte."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.wavelet_brdf.measured_scenes import ball, measured, table

from engine.brdf import measured as code
from engine.errors import Cancelled, InputError
from engine.methods import prepare
from engine.methods.wavelet_brdf import Settings, Wavelets, codes
from engine.scene.edits import Edits
from engine.scene.scene import Scene
from engine.store import Store

pytestmark = pytest.mark.usefixtures("small_codes")
TWO = (measured("plastic"), measured("brushed"))


def prepared(scene: Scene, store: Store, progress: Any = None, **settings: Any) -> Wavelets:
    chosen = Settings(**{"cells": 8, **settings})
    more = () if progress is None else (progress,)
    return prepare(scene, "wavelet_brdf", chosen, *more, store=store)  # type: ignore[return-value]


@pytest.fixture
def made(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """What `codes` encodes grows with every call: the bits of each."""
    calls: list[int] = []

    def counted(source: Any, bits: int, target: Any) -> Any:
        calls.append(bits)
        return code.encoded(source, bits, target)

    monkeypatch.setattr(codes, "measured", type("Counted", (), {
        "encoded": staticmethod(counted), "fill": staticmethod(code.fill), "NEAREST": code.NEAREST,
    }))  # fmt: skip
    return calls


def test_a_second_time_they_are_read_back(tmp_path: Path, made: list[int]) -> None:
    scene = table(*TWO)
    first, second = (prepared(scene, Store(tmp_path)) for _ in range(2))
    assert made == [3, 3]
    for one, two in zip(first._own.each, second._own.each, strict=True):
        assert one is not None
        assert two is not None
        assert one.data.tobytes() == bytes(two.data)
        assert one.grid == two.grid
        assert (one.error, one.worst, one.light, one.kept) == (
            two.error, two.worst, two.light, two.kept,
        )  # fmt: skip
    assert first.fits == second.fits
    assert first.bytes == second.bytes == sum(fit.bytes for fit in first.fits)
    pictures = [product.relight(Edits()).image.tobytes() for product in (first, second)]
    assert pictures[0] == pictures[1]


def test_an_interrupted_precompute_goes_on(tmp_path: Path, made: list[int]) -> None:
    """What is done is kept: the second time only the rest is made."""

    def stop(phase: str, done: float, total: float) -> None:
        assert (phase, total) == ("codes", 2)
        if done == 1:
            raise Cancelled("enough")

    scene = table(*TWO)
    with pytest.raises(Cancelled):
        prepared(scene, Store(tmp_path), stop)
    assert len(made) == 1
    prepared(scene, Store(tmp_path))
    assert len(made) == 2


def test_what_a_code_is_filed_under(tmp_path: Path, made: list[int]) -> None:
    """Neither the colour that multiplies it nor what is drawn, but all that changes its bytes."""
    store = Store(tmp_path)
    prepared(ball(measured()), store)
    prepared(ball(measured(specular=[0.1, 0.2, 0.3])), store, detail="finest", shadows=False)
    assert len(made) == 1
    for fields in ({"error": 0.05}, {"floor": 0.01}, {"bytes": 3000}, {"cells": 16}):
        before = len(made)
        prepared(ball(measured()), store, **fields)
        assert len(made) == before + 1
    prepared(ball(measured("brushed")), store)
    prepared(ball({"type": "ward"}), store)
    prepared(ball({"type": "ward", "roughness": 0.3}), store)
    assert len(made) == 8


def test_an_edit_makes_its_codes_once(tmp_path: Path, made: list[int]) -> None:
    product = prepared(ball(measured()), Store(tmp_path))
    for file in ("brushed", "plastic", "brushed", "plastic"):
        product.relight(Edits(materials={"ball": {"file": file}}))
    assert made == [3, 3]


def test_only_what_is_seen_is_encoded(tmp_path: Path, made: list[int]) -> None:
    """A material that nothing is made of, and one without gloss, have no code."""
    scene = table(measured(), {"type": "diffuse"})
    product = prepared(scene, Store(tmp_path))
    assert len(made) == 1
    assert [fit.name for fit in product.fits] == ["ball", "floor"]
    assert [fit.error > 0 for fit in product.fits] == [True, False]
    assert product.method == "wavelet_brdf"
    assert product.settings.cells == 8


def test_bytes_that_were_asked_for_are_kept_to(tmp_path: Path) -> None:
    scene = ball(measured("threads"))
    for size in (5000, 20_000):
        product = prepared(scene, Store(tmp_path), bytes=size, cells=16)
        assert 0.9 * size < product.bytes <= size
        assert np.isfinite(product.relight(Edits()).image).all()
    with pytest.raises(InputError, match=r"the least is \d+ bytes, not 2000") as caught:
        prepared(scene, Store(tmp_path), bytes=2000, cells=16)
    assert caught.value.field == "bytes"
