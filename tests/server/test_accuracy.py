"""The chart of a method's settings, and a frame beside its reference."""

from __future__ import annotations

import io
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from fastapi import FastAPI
from httpx import Client
from PIL import Image

from engine.measure import front as module
from engine.measure.pilots import Cost
from engine.methods.base import Progress
from server.app import create_app
from server.precompute import Task
from server.work import do

CHART = "/api/scenes/tiny-box/chart"
REFERENCE = "/api/scenes/tiny-box/reference"


class Pilots:
    """Made-up ones: the more wavelets the less error, and the longer a frame."""

    def __init__(self, *_: Any) -> None:
        pass

    def run(self, method: str, settings: Any) -> Cost:
        count = settings.coefficients
        return Cost(1 / count, 1e-4 * count, 1e4 * count, 1.0)

    def whole(self, method: str, settings: Any, small: Cost) -> Cost:
        return small


class Here:
    """Does tasks in this process, once it is let go."""

    def __init__(self) -> None:
        self.go = threading.Event()

    def __call__(self, task: Task, progress: Progress) -> None:
        while not self.go.is_set():
            progress("waiting", 0, 1)
            time.sleep(0.005)
        do(task, progress)


@pytest.fixture
def here() -> Here:
    return Here()


@pytest.fixture
def at(
    tiny_scene: Path,
    quick: dict[str, int],
    here: Here,
    serving: Callable[[FastAPI], AbstractContextManager[str]],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[Client]:
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path))
    monkeypatch.setattr(module, "Pilots", Pilots)
    app = create_app([str(tiny_scene)], precompute=here, precompute_at_start=False, settings=quick)
    with serving(app) as address, httpx.Client(base_url=address, timeout=60) as client:
        yield client


def ended(client: Client, job: dict[str, Any]) -> dict[str, Any]:
    for _ in range(6000):  # kernels may have to be compiled
        state: dict[str, Any] = client.get(f"/api/jobs/{job['id']}").json()
        if state["status"] not in ("queued", "running"):
            return state
        time.sleep(0.01)
    raise AssertionError("it did not end")


def test_a_chart_is_measured_when_asked_for_and_follows_the_settings(
    at: Client, here: Here
) -> None:
    chart = at.get(CHART).json()
    assert (chart["kinds"], chart["points"], chart["job"]) == (["lights"], [], None)
    answer = at.post(CHART)
    job = answer.json()
    assert (answer.status_code, answer.headers["location"]) == (202, f"/api/jobs/{job['id']}")
    assert (job["work"], job["method"]) == ("front", "direct_to_indirect")
    assert at.post(CHART).json()["id"] == at.get(CHART).json()["job"]["id"] == job["id"]
    assert at.delete(f"/api/jobs/{job['id']}").status_code == 200
    assert ended(at, job)["status"] == "cancelled"

    here.go.set()
    assert ended(at, at.post(CHART).json())["status"] == "done"
    chart = at.get(CHART).json()
    first, *steps = chart["points"]
    assert (first["settings"]["coefficients"], first["cost"]["error"]) == (
        30,
        pytest.approx(1 / 30),
    )
    assert [step["settings"]["coefficients"] for step in steps] == [12, 25, 50, 100, 200, 400]
    assert first["best"]
    assert chart["current"] == 0
    # Frames take the settings that were asked for by name, at this view and at others.
    wanted = {**steps[0]["settings"], "gather_samples": 1024}
    asked = at.post("/api/scenes/tiny-box/precompute", json={"settings": wanted}).json()
    assert ended(at, asked)["status"] == "done"
    assert at.get(CHART).json()["current"] == 1


def test_a_frame_beside_its_reference(at: Client, here: Here) -> None:
    edits = {"lights": [{"id": "key", "enabled": False}]}
    answer = at.post(REFERENCE, json=edits, params={"noise": 0.2, "seconds": 5})
    job = answer.json()
    assert (answer.status_code, job["work"]) == (202, "reference")
    result = f"/api/jobs/{job['id']}/reference"
    assert answer.headers["location"] == f"/api/jobs/{job['id']}"
    early = at.get(result)
    assert (early.status_code, early.json()["detail"]) == (404, "the reference is not there yet")
    here.go.set()
    assert ended(at, job)["status"] == "done"
    answer = at.get(result).json()
    found = answer["verdict"]
    # The service has no product, so the frame lacks all indirect light.
    assert answer["method"] == "direct"
    assert 0.1 < found["error"] < 0.9
    assert 0 < found["noise"] <= 0.2
    assert 5 < found["psnr"] < 40
    assert answer["samples"] >= 64
    pictures = {}
    for which in ("live", "reference", "difference"):
        got = at.get(f"{result}/{which}", params={"exposure": 1})
        assert got.headers["content-type"] == "image/png"
        pictures[which] = np.asarray(Image.open(io.BytesIO(got.content)), np.float64)
    frame = at.post(
        "/api/scenes/tiny-box/frame", json=edits, params={"exposure": 1},
        headers={"accept": "image/png"},
    )  # fmt: skip
    assert np.array_equal(pictures["live"], np.asarray(Image.open(io.BytesIO(frame.content))))
    assert pictures["reference"].mean() > pictures["live"].mean() + 5
    red, _, blue = pictures["difference"].mean((0, 1))
    assert blue > red + 10, "too dark is blue"


@pytest.mark.parametrize(
    ("method", "path", "status", "field"),
    [
        ("GET", "/api/scenes/none/chart", 404, ""),
        ("GET", f"{CHART}?method=none", 404, ""),
        ("POST", f"{CHART}?method=glossy_prt", 422, "method"),
        ("POST", f"{REFERENCE}?method=none", 404, ""),
        ("POST", f"{REFERENCE}?seconds=1000", 422, "seconds"),
        ("POST", f"{REFERENCE}?settings=[", 422, "settings"),
        ("GET", "/api/jobs/none/reference", 404, ""),
        ("GET", "/api/jobs/none/reference/picture", 422, "which"),
    ],
)
def test_what_there_is_not(client: Client, method: str, path: str, status: int, field: str) -> None:
    answer = client.request(method, path)
    assert (answer.status_code, answer.json()["field"]) == (status, field), answer.text
    assert answer.headers["content-type"] == "application/problem+json"


def test_nothing_to_edit_has_no_chart(client: Client) -> None:
    assert client.get(f"{CHART}?method=glossy_prt").json()["kinds"] == []
