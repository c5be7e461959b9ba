"""The helper for scripts and notebooks, and the README's example of it."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fastapi import FastAPI
from PIL import Image

from engine.errors import RelightError
from server.app import create_app
from server.client import Relight
from server.rates import Rate, Rates
from server.work import do

README = Path(__file__).resolve().parents[2] / "README.md"
OFF = [{"id": "key", "enabled": False}]


@pytest.fixture(scope="module")
def address(
    tiny_scene: Path,
    quick: dict[str, int],
    serving: Callable[[FastAPI], AbstractContextManager[str]],
) -> Iterator[str]:
    app = create_app([str(tiny_scene)], precompute=do, precompute_at_start=False, settings=quick)
    with serving(app) as address:
        yield address


@pytest.fixture
def relight(address: str) -> Iterator[Relight]:
    with Relight(address) as relight:
        yield relight


def test_pictures_by_a_few_lines(relight: Relight) -> None:
    assert relight.scenes()[0] == "tiny-box"
    assert [light["id"] for light in relight.scene("tiny-box")["lights"]] == ["ceiling", "key"]
    relight.prepare("tiny-box")
    both = relight.frame("tiny-box")
    assert both.info["method"] == "direct_to_indirect"
    assert both.size == (24, 18)
    assert both._repr_png_().startswith(b"\x89PNG")
    ceiling = np.asarray(relight.frame("tiny-box", lights=OFF), float)
    assert 0 < ceiling.mean() < np.asarray(both, float).mean()
    brighter = np.asarray(relight.frame("tiny-box", lights=OFF, exposure=1), float)
    assert brighter.mean() > ceiling.mean()


def test_what_is_refused_is_said(relight: Relight) -> None:
    with pytest.raises(RelightError, match=r"^lights\.0\.position"):
        relight.frame("tiny-box", lights=[{"id": "key", "position": [0, 1]}])
    with pytest.raises(RelightError, match="there is no scene 'none'"):
        relight.frame("none")


def test_it_comes_back_when_told(
    tiny_scene: Path,
    serving: Callable[[FastAPI], AbstractContextManager[str]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    sleep, waits = time.sleep, list[float]()
    monkeypatch.setattr("server.client.time.sleep", lambda s: (waits.append(s), sleep(s)))
    rates = Rates(requests=Rate(1, 1.0))
    app = create_app([str(tiny_scene)], precompute_at_start=False, rates=rates)
    with serving(app) as address, Relight(address) as relight:
        assert relight.scenes() == relight.scenes()
    assert 1.0 in waits


def test_the_examples_of_the_readme(
    address: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As they stand there, but for the address and a smaller scene."""
    blocks = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
    monkeypatch.chdir(tmp_path)
    kept: dict[str, Any] = {}
    for block in blocks:
        assert "http://127.0.0.1:8000" in block
        code = block.replace("http://127.0.0.1:8000", address).replace("cornell-box", "tiny-box")
        exec(code, kept)
    with Image.open(tmp_path / "frame.png") as frame:
        assert frame.size == kept["picture"].size == (24, 18)
    assert kept["picture"].info["method"] == "direct_to_indirect"
    kept["relight"].close()
