"""A preview of a product is drawn with until the whole one is there, and never taken for it."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import replace
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from engine.methods.base import Progress, silent
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from server import products, work
from server.app import create_app
from server.precompute import PREVIEW, PREVIEW_READY, Task
from server.stages import stages

Serving = Callable[[FastAPI], AbstractContextManager[str]]
FRAME = "/api/scenes/tiny-box/frame"


class Gate:
    """The work of the process, in a thread; it waits between the preview and the whole."""

    def __init__(self) -> None:
        self.open = threading.Event()
        self.phases: list[str] = []

    def __call__(self, task: Task, progress: Progress) -> None:
        def told(phase: str, done: float, total: float) -> None:
            self.phases.append(phase)
            progress(phase, done, total)
            while phase == PREVIEW_READY and not self.open.is_set():
                progress(phase, done, total)
                time.sleep(0.01)

        work.do(task, told)


@pytest.fixture(autouse=True)
def own_store(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path))
    return tmp_path


@pytest.fixture(autouse=True)
def worth_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """The tiny scene is taken for one that takes long."""

    def settings(scene: Scene, method: str, whole: Any) -> Any:
        return replace(whole, gather_samples=256, view_rays=16)

    monkeypatch.setattr(work, "preview_settings", settings)
    monkeypatch.setattr(products, "preview_settings", settings)


@pytest.fixture
def gate() -> Gate:
    return Gate()


@pytest.fixture
def client(
    tiny_scene: Path, gate: Gate, serving: Serving, quick: dict[str, int]
) -> Iterator[httpx.Client]:
    app = create_app([str(tiny_scene)], precompute=gate, settings=quick)
    with serving(app) as address, httpx.Client(base_url=address, timeout=60) as client:
        yield client


def drawn(client: httpx.Client) -> tuple[dict[str, Any], set[str], bytes]:
    """(header, codes of its warnings, lossless picture)."""
    answer = client.post(FRAME, json={}, headers={"Accept": "image/png"})
    header = json.loads(answer.headers["Relight-Frame"])
    return header, {warning["code"] for warning in header["warnings"]}, answer.content


def until(true: Callable[[], bool], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it never became true"
        time.sleep(0.01)


def is_ready(client: httpx.Client) -> bool:
    methods = client.get("/api/scenes/tiny-box").json()["methods"]
    return bool(next(m["ready"] for m in methods if m["name"] == "direct_to_indirect"))


def test_the_preview_comes_first_and_goes_when_the_whole_is_there(
    client: httpx.Client, gate: Gate, own_store: Path
) -> None:
    until(lambda: "preview_shown" in drawn(client)[1])
    header, _, early = drawn(client)
    assert header["method"] == "direct_to_indirect"
    size = header["width"], header["height"]
    job = client.get(f"/api/jobs/{header['job']}").json()
    assert (job["status"], job["preview"]) == ("running", True)
    assert not is_ready(client)
    until(lambda: not list(own_store.glob("previews/*")))
    assert not list(own_store.glob("*/final.relight")), "it lies where the whole one belongs"
    gate.open.set()
    until(lambda: drawn(client)[0]["job"] is None)
    header, codes, whole = drawn(client)
    assert "preview_shown" not in codes
    assert whole != early
    assert (header["width"], header["height"]) == size
    assert is_ready(client)


def test_cancelled_in_between_it_stays(client: httpx.Client, gate: Gate) -> None:
    until(lambda: "preview_shown" in drawn(client)[1])
    job = drawn(client)[0]["job"]
    start = time.monotonic()
    client.delete(f"/api/jobs/{job}")
    until(lambda: client.get(f"/api/jobs/{job}").json()["status"] == "cancelled", 1.0)
    assert time.monotonic() - start < 1.0
    header, codes, _ = drawn(client)
    assert header["job"] == job
    assert "preview_shown" in codes
    assert not is_ready(client)
    # Asked for again, it does without another preview.
    del gate.phases[:]
    gate.open.set()
    client.post("/api/scenes/tiny-box/precompute", json={})
    until(lambda: "preview_shown" not in drawn(client)[1])
    assert not [phase for phase in gate.phases if phase.startswith(PREVIEW)]


def test_what_is_stored_is_loaded_without_a_process(
    tiny_scene: Path, quick: dict[str, int]
) -> None:
    there = stages([str(tiny_scene)])
    task = Task(
        scene="tiny-box", source=str(tiny_scene), camera=open_scene(tiny_scene).camera,
        method="direct_to_indirect", settings=quick, preview=True,
    )  # fmt: skip
    asked: list[str] = []

    def precompute(task: Task, progress: Progress) -> None:
        asked.append(task.scene)
        work.do(task, progress)

    makes = products.Products(there, precompute, lambda task: None)
    for times in (1, 1):
        makes(task, silent)
        assert len(asked) == times
        assert there.default.product(task.camera) is not None
    makes.close()
