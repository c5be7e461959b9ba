"""How much one client may ask for, and what it hears beyond that."""

from __future__ import annotations

import itertools
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path

import numpy as np
import pytest
from fastapi import FastAPI
from httpx import Client, Response
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

from engine.errors import BackendError
from engine.methods.base import Progress
from server import rates as module
from server.app import create_app
from server.precompute import Task
from server.rates import Ledger, Rate, Rates, client_of
from server.service import Service

FEW = Rates(Rate(20, 0.5), Rate(2, 0.1), Rate(3, 0.1), at_once=2, sessions=2, all_sessions=3)


def refused(task: Task, progress: Progress) -> None:
    raise BackendError("no precompute in this test")


@pytest.fixture(scope="module")
def app(tiny_scene: Path) -> FastAPI:
    return create_app([str(tiny_scene)], precompute=refused, precompute_at_start=False, rates=FEW)


@pytest.fixture(scope="module")
def address(
    app: FastAPI, serving: Callable[[FastAPI], AbstractContextManager[str]]
) -> Iterator[str]:
    with serving(app) as address:
        yield address


NUMBERS = itertools.count(1)


@pytest.fixture
def ask(address: str) -> Iterator[Client]:
    """Somebody of whom the service has not heard, behind a proxy on this machine."""
    host = f"10.1.2.{next(NUMBERS)}"
    headers = {"X-Forwarded-For": host}
    with Client(base_url=address, headers=headers, timeout=60) as client:
        yield client


def test_never_more_than_the_burst_and_the_rate() -> None:
    """However somebody asks, any span of time t holds at most burst + t * rate of it."""
    rate, ledger, rng = Rate(5, 2.0), Ledger(), np.random.default_rng(3)
    times = np.cumsum(rng.exponential(0.2, 400))
    taken = np.array([t for t in times if ledger.wait("a", "requests", rate, t) == 0])
    assert len(taken) < len(times)
    for first in range(len(taken)):
        for last in range(first, len(taken)):
            most = rate.burst + (taken[last] - taken[first]) * rate.per_second
            assert last - first + 1 <= most + 1e-6


def test_who_waits_as_long_as_told_may_ask() -> None:
    rate, ledger = Rate(2, 0.5), Ledger()
    waits = [ledger.wait("a", "jobs", rate, 10.0) for _ in range(3)]
    assert waits[:2] == [0, 0]
    assert waits[2] == pytest.approx(2.0)
    assert ledger.wait("a", "jobs", rate, 11.9) > 0
    assert ledger.wait("a", "jobs", rate, 12.0) == 0
    # Others, and other things, are counted by themselves.
    assert ledger.wait("b", "jobs", rate, 10.0) == ledger.wait("a", "uploads", rate, 10.0) == 0


def test_who_has_been_quiet_is_forgotten(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "MOST_KEPT", 10)
    ledger = Ledger()
    for k in range(1000):
        ledger.wait(str(k), "requests", Rate(5, 1.0), 10.0 * k)
    assert len(ledger._due) <= 11


@pytest.mark.parametrize(
    ("host", "client"),
    [
        ("192.0.2.7", "192.0.2.7"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("2001:db8:1:2::9", "2001:db8:1:2::/64"),
        ("::ffff:192.0.2.7", "192.0.2.7"),
        ("unknown", "unknown"),
    ],
)
def test_a_client_is_an_address(host: str, client: str) -> None:
    assert client_of({"type": "http", "client": (host, 1)}) == client


def too_many(answer: Response, words: str) -> int:
    """Seconds after which to ask again."""
    assert answer.status_code == 429, answer.text
    assert words in answer.json()["detail"]
    assert answer.headers["content-type"] == "application/problem+json"
    return int(answer.headers["retry-after"])


def test_too_many_requests(ask: Client, address: str) -> None:
    answers = [ask.get("/api/scenes") for _ in range(21)]
    assert [answer.status_code for answer in answers] == [200] * 20 + [429]
    assert too_many(answers[-1], "20 requests, and 0.5 more a second") == 2
    # Neither the page nor somebody else is held up.
    assert ask.get("/").status_code == ask.get("/healthz").status_code == 200
    other = {"X-Forwarded-For": "10.9.9.9"}
    assert ask.get("/api/scenes", headers=other).status_code == 200
    assert 'relight_problems_total{status="429"} ' in ask.get("/metrics").text


@pytest.mark.parametrize(
    ("path", "most", "words"),
    [
        ("/api/maps", 2, "2 uploads"),
        ("/api/scenes/tiny-box/precompute", 3, "3 jobs"),
        ("/api/scenes/tiny-box/chart?method=none", 3, "3 jobs"),
    ],
)
def test_too_many_files_or_jobs(ask: Client, path: str, most: int, words: str) -> None:
    answers = [ask.post(path) for _ in range(most + 1)]
    assert 429 not in [answer.status_code for answer in answers[:-1]]
    assert too_many(answers[-1], words) == 10
    assert ask.get("/api/scenes").status_code == 200


def test_too_many_frames_at_once(ask: Client, app: FastAPI) -> None:
    service: Service = app.state.service
    ask.post("/api/scenes/tiny-box/frame", json={})
    go = threading.Event()
    service.worker._pool.submit(go.wait)
    with ThreadPoolExecutor(2) as pool:
        frames = [pool.submit(ask.post, "/api/scenes/tiny-box/frame", json={}) for _ in range(2)]
        while service.worker.waiting < 2:
            pass
        assert too_many(ask.post("/api/scenes/tiny-box/frame", json={}), "2 frames") == 1
        go.set()
        assert [frame.result().status_code for frame in frames] == [200, 200]
    assert ask.post("/api/scenes/tiny-box/frame", json={}).status_code == 200


def test_too_many_sockets(address: str) -> None:
    url = f"{address.replace('http', 'ws')}/api/scenes/tiny-box/live"

    def status(host: str) -> tuple[int, str]:
        headers = {"X-Forwarded-For": host}
        with pytest.raises(InvalidStatus) as refused, connect(url, additional_headers=headers):
            pass
        answer = refused.value.response
        return answer.status_code, answer.headers["Retry-After"]

    with ExitStack() as stack:
        for host in ("10.3.0.1", "10.3.0.1", "10.3.0.2"):
            stack.enter_context(connect(url, additional_headers={"X-Forwarded-For": host}))
        assert status("10.3.0.1") == (429, "5")
        assert status("10.3.0.3") == (503, "5"), "all are taken"
    # The service hears a moment later that they were closed.
    for _ in range(200):
        try:
            with connect(url, additional_headers={"X-Forwarded-For": "10.3.0.1"}):
                break
        except InvalidStatus:
            time.sleep(0.02)
    else:
        pytest.fail("nothing was given back")
