"""The live socket: newest edit wins, two frames in flight, better products arrive by themselves."""

from __future__ import annotations

import io
import json
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
from numpy.typing import NDArray
from PIL import Image
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from engine.methods.base import Progress
from server.app import create_app
from server.precompute import Task

Serving = Callable[[FastAPI], AbstractContextManager[str]]
BEHIND = {"camera": {"position": [0.278, 0.273, -1.0]}}


class Gate:
    """A precompute that waits to be let through, then leaves the work to the load after it."""

    def __init__(self) -> None:
        self.open = threading.Event()
        self.tasks: list[Task] = []
        self.stopped: list[Task] = []

    def __call__(self, task: Task, progress: Progress) -> None:
        self.tasks.append(task)
        try:
            while not self.open.is_set():
                progress("waiting", 1, 4)
                time.sleep(0.01)
        except BaseException:
            self.stopped.append(task)
            raise


@pytest.fixture
def gate() -> Gate:
    return Gate()


@pytest.fixture
def address(
    tiny_scene: Path,
    gate: Gate,
    serving: Serving,
    quick: dict[str, int],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> Iterator[str]:
    """With a store of its own: what another test has stored would not wait at the gate."""
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path))
    app = create_app([str(tiny_scene)], precompute=gate, precompute_at_start=False, settings=quick)
    with serving(app) as address:
        yield address


class Client:
    """Sorts what arrives into frames and messages."""

    def __init__(self, socket: ClientConnection) -> None:
        self.socket = socket

    def edit(self, seq: int, edits: object = None, **more: Any) -> None:
        message = {"type": "edit", "seq": seq, "edits": edits or {}, "format": "png", **more}
        self.socket.send(json.dumps(message))

    def ack(self, seq: int) -> None:
        self.socket.send(json.dumps({"type": "ack", "seq": seq}))

    def receive(self, timeout: float = 60) -> tuple[dict[str, Any], NDArray[np.uint8] | None]:
        data = self.socket.recv(timeout=timeout)
        if isinstance(data, str):
            return json.loads(data), None
        length = int.from_bytes(data[:4], "little")
        header = json.loads(data[4 : 4 + length])
        return header, np.asarray(Image.open(io.BytesIO(data[4 + length :])))

    def frame(self, timeout: float = 60) -> tuple[dict[str, Any], NDArray[np.uint8]]:
        """The next frame, acknowledged; other messages are skipped."""
        while True:
            header, image = self.receive(timeout)
            if image is not None:
                self.ack(header["seq"])
                return header, image

    def unacknowledged(self) -> dict[str, Any]:
        """The header of the next frame, which the service takes for not shown yet."""
        while True:
            header, image = self.receive()
            if image is not None:
                return header

    def message(self, kind: str) -> dict[str, Any]:
        while True:
            message, image = self.receive()
            if image is not None:
                self.ack(message["seq"])
            elif message["type"] == kind:
                return message

    def silent(self, seconds: float = 0.4) -> bool:
        """Whether no frame comes for a while."""
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            try:
                _, image = self.receive(left)
            except TimeoutError:
                return True
            if image is not None:
                return False
        return True


@pytest.fixture
def live(address: str) -> Iterator[Client]:
    url = f"{address.replace('http', 'ws')}/api/scenes/tiny-box/live"
    with connect(url) as socket:
        yield Client(socket)


def test_a_frame_per_edit(live: Client) -> None:
    live.edit(1)
    header, image = live.frame()
    assert (header["seq"], header["method"], header["format"]) == (1, "direct", "png")
    assert (header["height"], header["width"], 3) == image.shape == (18, 24, 3)
    assert header["timings"]["total"] > 0
    assert header["warnings"][0]["code"] == "indirect_pending"
    live.edit(2, {"lights": [{"id": "key", "enabled": False}]}, scale=2)
    header, dark = live.frame()
    assert (header["seq"], dark.shape) == (2, (9, 12, 3))
    assert dark.mean() < image.mean()


def test_the_newest_edit_wins_and_two_are_in_flight(live: Client) -> None:
    # Two frames come without an acknowledgement, no third.
    for seq in (1, 2):
        live.edit(seq)
        assert live.unacknowledged()["seq"] == seq
    for seq in range(3, 41):
        live.edit(seq, {"lights": [{"id": "key", "intensity": [seq, seq, seq]}]})
    assert live.silent()
    # With room again, the newest is drawn and those before it never.
    live.ack(1)
    assert live.unacknowledged()["seq"] == 40
    live.ack(2)
    assert live.silent()


def test_an_older_edit_is_not_drawn_after_a_newer_one(live: Client) -> None:
    live.edit(5)
    assert live.frame()[0]["seq"] == 5
    live.edit(4)
    assert live.silent()


@pytest.mark.parametrize(
    ("text", "field"),
    [
        ("{", ""),
        ("[]", ""),
        ('{"type": "edit"}', "seq"),
        ('{"type": "edit", "seq": -1}', "seq"),
        ('{"type": "edit", "seq": 1, "exposure": NaN}', "exposure"),
        ('{"type": "edit", "seq": 1, "scale": 0}', "scale"),
        ('{"type": "edit", "seq": 1, "edits": {"lamp": 1}}', "lamp"),
        ('{"type": "edit", "seq": 1, "edits": {"lights": [{"id": "key", "position": [0, NaN, 0]}]'
         "}}", "lights.0.position.1"),
        ('{"type": "edit", "seq": 1, "edits": {"materials": {"white": {"diffuse": [0,0,0]}}}}',
         "materials"),
        ('{"type": "hello"}', ""),
    ],
)  # fmt: skip
def test_what_cannot_be_drawn_is_told_and_nothing_else_dies(
    live: Client, text: str, field: str
) -> None:
    live.socket.send(text)
    problem = live.message("problem")["problem"]
    assert problem["detail"]
    assert problem["field"] == field
    live.edit(7)
    assert live.frame()[0]["seq"] == 7


def test_an_unknown_scene_is_told_before_the_end(address: str) -> None:
    with connect(f"{address.replace('http', 'ws')}/api/scenes/none/live") as socket:
        assert json.loads(socket.recv())["problem"]["status"] == 404
        with pytest.raises(ConnectionClosed) as closed:
            socket.recv()
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 4404


def test_the_indirect_light_arrives_by_itself(live: Client, gate: Gate, address: str) -> None:
    live.edit(1)
    header, direct = live.frame()
    assert header["job"]
    running = live.message("job")["job"]
    if running["status"] == "queued":  # as a busy machine may tell first
        running = live.message("job")["job"]
    assert (running["id"], running["status"]) == (header["job"], "running")
    with httpx.stream("GET", f"{address}/api/jobs/{header['job']}/events") as events:
        gate.open.set()
        lines = [line for line in events.iter_lines() if line.startswith("data: ")]
    assert json.loads(lines[-1].removeprefix("data: "))["status"] == "done"
    header, full = live.frame()
    assert (header["seq"], header["method"]) == (1, "direct_to_indirect")
    assert header["job"] is None
    assert "indirect_pending" not in [warning["code"] for warning in header["warnings"]]
    # The ceiling is lit by nothing but bounces.
    assert full[0, 8:16].mean() > direct[0, 8:16].mean() + 2
    assert full.mean() > direct.mean()
    scene = httpx.get(f"{address}/api/scenes/tiny-box").json()
    assert scene["methods"][0]["ready"]
    assert scene["methods"][0]["bytes"] > 0


def test_another_camera_shows_direct_light_and_stops_the_old_job(
    live: Client, gate: Gate, address: str
) -> None:
    live.edit(1)
    old, before = live.frame()
    live.edit(2, BEHIND, scale=2)
    moving, _ = live.frame()
    assert moving["seq"] == 2
    assert len(gate.tasks) <= 1, "a camera on its way prepares nothing"
    live.edit(3, BEHIND)
    new, after = live.frame()
    assert new["method"] == "direct"
    assert new["job"] not in (None, old["job"])
    assert np.abs(after.astype(int) - before).mean() > 3
    assert httpx.get(f"{address}/api/jobs/{old['job']}").json()["status"] != "done"
    end = time.monotonic() + 1.0
    while httpx.get(f"{address}/api/jobs/{old['job']}").json()["status"] != "cancelled":
        assert time.monotonic() < end, "not cancelled within a second"
        time.sleep(0.02)
    assert gate.tasks[0] in gate.stopped


def test_a_cancelled_precompute_is_not_begun_again_by_looking(
    live: Client, gate: Gate, address: str
) -> None:
    live.edit(1)
    job = live.frame()[0]["job"]
    assert httpx.delete(f"{address}/api/jobs/{job}").status_code == 200
    while live.message("job")["job"]["status"] != "cancelled":
        pass
    live.edit(2)
    assert live.frame()[0]["job"] == job
    started = httpx.post(f"{address}/api/scenes/tiny-box/precompute", json={})
    assert started.status_code == 202
    assert started.headers["location"] == f"/api/jobs/{started.json()['id']}"
    assert started.json()["id"] != job
    live.edit(3)
    assert live.frame()[0]["job"] == started.json()["id"]


@pytest.mark.parametrize(
    ("body", "status", "field"),
    [
        ({"method": "magic"}, 404, ""),
        ({"settings": {"magic": 1}}, 422, "settings.magic"),
        ({"edits": {"lights": [{"id": "key"}]}}, 422, "edits.lights"),
        ({"edits": {"camera": {"width": -1}}}, 422, "camera.width"),
        ({"magic": 1}, 422, "magic"),
    ],
)
def test_bad_precomputes(address: str, body: object, status: int, field: str) -> None:
    response = httpx.post(f"{address}/api/scenes/tiny-box/precompute", json=body)
    assert (response.status_code, response.json()["field"]) == (status, field)
