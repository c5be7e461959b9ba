"""What fails while a frame is made answers that request alone; a lost GL costs no picture."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import httpx
import moderngl
import pytest
from fastapi import FastAPI
from websockets.sync.client import connect

from engine.backend import choice
from engine.methods.base import Frame, Progress
from engine.methods.direct_to_indirect.product import Transfer
from engine.store import Store
from server.app import create_app
from server.precompute import Task
from server.stage import View

Serving = Callable[[FastAPI], AbstractContextManager[str]]
FRAME = "/api/scenes/tiny-box/frame"
PNG = {"Accept": "image/png"}


def at_load(task: Task, progress: Progress) -> None:
    """A precompute that leaves the work to the load after it."""


@pytest.fixture
def whole(tiny_scene: Path, serving: Serving, quick: dict[str, int]) -> Iterator[httpx.Client]:
    """A service that has its product."""
    app = create_app([str(tiny_scene)], precompute=at_load, settings=quick)
    with serving(app) as address, httpx.Client(base_url=address, timeout=60) as client:
        drawn_by(client, "direct_to_indirect")
        yield client


def drawn(client: httpx.Client) -> tuple[dict[str, Any], bytes]:
    """(header, lossless picture)."""
    answer = client.post(FRAME, json={}, headers=PNG)
    assert answer.status_code == 200, answer.text
    return json.loads(answer.headers["Relight-Frame"]), answer.content


def drawn_by(client: httpx.Client, method: str) -> bytes:
    end = time.monotonic() + 60
    while time.monotonic() < end:
        header, picture = drawn(client)
        if header["method"] == method:
            return picture
    raise AssertionError(f"no frame of {method} came")


@pytest.mark.parametrize(
    ("error", "status"), [(ValueError("/the/secret"), 500), (MemoryError("/the/secret"), 503)]
)
def test_an_error_answers_its_request_and_the_next_one_is_drawn(
    client: httpx.Client, monkeypatch: pytest.MonkeyPatch, error: Exception, status: int
) -> None:
    healthy, failing = View.relight, [True, True]

    def relight(self: View, *args: Any) -> Frame:
        if failing:
            failing.pop()
            raise error
        return healthy(self, *args)

    monkeypatch.setattr(View, "relight", relight)
    answer = client.post(FRAME, json={}, headers=PNG)
    assert (answer.status_code, answer.json()["status"]) == (status, status)
    assert answer.json()["detail"]
    assert "secret" not in answer.text
    address = str(client.base_url).replace("http", "ws")
    with connect(f"{address}/api/scenes/tiny-box/live") as socket:
        socket.send(json.dumps({"type": "edit", "seq": 1}))
        said = json.loads(socket.recv(timeout=60))
        assert (said["type"], said["seq"], said["problem"]["status"]) == ("problem", 1, status)
        socket.send(json.dumps({"type": "edit", "seq": 2}))
        while not isinstance(frame := socket.recv(timeout=60), bytes):
            pass
        assert b'"seq":2' in frame
    assert client.post(FRAME, json={}, headers=PNG).status_code == 200


def test_gl_is_lost_and_the_cpu_goes_on(
    whole: httpx.Client, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The device stands in for a GPU; the CPU makes its pictures."""
    truth, lost = drawn_by(whole, "direct_to_indirect"), [False]
    calls: list[bool] = []

    def by_gl(self: Transfer, device: Any, *args: Any) -> Any:
        calls.append(lost[0])
        if lost[0]:
            raise moderngl.Error("cannot map the buffer")
        return self._by_cpu(*args)

    monkeypatch.setenv(choice.VARIABLE, "gl")
    monkeypatch.setattr(choice, "device", lambda: SimpleNamespace(software=False))
    monkeypatch.setattr(Transfer, "_by_gl", by_gl)
    header, picture = drawn(whole)
    assert (calls, picture) == ([False], truth)
    assert "gl_unavailable" not in [warning["code"] for warning in header["warnings"]]
    lost[0] = True
    for _ in range(2):
        header, picture = drawn(whole)
        assert picture == truth
        codes = [warning["code"] for warning in header["warnings"]]
        assert codes.count("gl_unavailable") == 1
    assert calls == [False, True], "GL was asked again"


def test_a_broken_product_is_made_again(
    whole: httpx.Client, tiny_scene: Path, serving: Serving, quick: dict[str, int]
) -> None:
    truth = drawn_by(whole, "direct_to_indirect")
    files = [path for path in Store().root.glob("*/final.relight") if path.stat().st_size > 1000]
    assert files
    for path in files:
        data = bytearray(path.read_bytes())
        data[len(data) // 2] ^= 1
        path.write_bytes(data)
    app = create_app([str(tiny_scene)], precompute=at_load, settings=quick)
    with serving(app) as address, httpx.Client(base_url=address, timeout=60) as client:
        assert drawn_by(client, "direct_to_indirect") == truth
