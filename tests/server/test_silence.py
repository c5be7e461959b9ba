"""Clients of the live socket that stop reading, or acknowledging, and those beside them."""

from __future__ import annotations

import asyncio
import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import get_args

import httpx
import numpy as np
import pytest
from fastapi import FastAPI
from websockets.sync.client import connect

from engine.errors import BackendError
from engine.methods.base import Progress
from server import live as module
from server.app import create_app
from server.bench_load import Hand, Stop, Target, drag_together, header_of, stop
from server.precompute import Task
from server.service import Service

SILENT_SECONDS = 0.3


def refused(task: Task, progress: Progress) -> None:
    raise BackendError("no precompute in this test")


@pytest.fixture(scope="module")
def app(tiny_scene: Path) -> FastAPI:
    return create_app([str(tiny_scene)], precompute=refused, precompute_at_start=False)


@pytest.fixture(scope="module")
def target(
    app: FastAPI, serving: Callable[[FastAPI], AbstractContextManager[str]]
) -> Iterator[Target]:
    with serving(app) as address, pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "SILENT_SECONDS", SILENT_SECONDS)
        yield Target(address, "tiny-box", "key", (0.45, 0.5, 0.06), 0.05)


def test_who_stops_is_dropped_and_others_go_on(target: Target, app: FastAPI) -> None:
    service: Service = app.state.service

    async def beside() -> tuple[list[Hand], int]:
        hands = asyncio.create_task(drag_together(target, 2, 1.5))
        stopping = [asyncio.create_task(stop(target, how, 1.4)) for how in get_args(Stop)]
        await asyncio.sleep(0.2)
        assert service.sessions == 5
        await asyncio.sleep(SILENT_SECONDS + 0.7)
        left = service.sessions
        await asyncio.gather(*stopping)
        return await hands, left

    hands, left = asyncio.run(beside())
    # What is acknowledged without being read fills the system's buffers first: the bench waits.
    assert left == 3
    for hand in hands:
        assert hand.frames > 10
        assert (hand.stale, hand.errors) == (0, [])
    end = time.monotonic() + 5
    while service.sessions:
        assert time.monotonic() < end, "a session was left"
        time.sleep(0.01)


def test_who_rests_with_nothing_to_acknowledge_stays(target: Target) -> None:
    with connect(target.live) as socket:
        for seq in (1, 2):
            socket.send(json.dumps({"type": "edit", "seq": seq}))
            data = socket.recv()
            while isinstance(data, str):
                data = socket.recv()
            assert header_of(data)["seq"] == seq
            socket.send(json.dumps({"type": "ack", "seq": seq}))
            time.sleep(1.5 * SILENT_SECONDS)


def test_a_frame_shows_the_edit_that_it_names_and_none_is_stale(target: Target) -> None:
    """Numbers never go back, and a picture is that of its number, asked for by itself."""

    def edits(seq: int) -> dict[str, object]:
        return {"lights": [{"id": "key", "intensity": [seq / 100] * 3}]}

    shown: list[tuple[int, bytes]] = []
    with connect(target.live) as socket:
        for seq in range(1, 61):
            message = {"type": "edit", "seq": seq, "edits": edits(seq), "format": "png"}
            socket.send(json.dumps(message))
            time.sleep(0.002)
        while not shown or shown[-1][0] < 60:
            data = socket.recv()
            if isinstance(data, bytes):
                length = int.from_bytes(data[:4], "little")
                shown.append((header_of(data)["seq"], data[4 + length :]))
                socket.send(json.dumps({"type": "ack", "seq": shown[-1][0]}))
    numbers = [seq for seq, _ in shown]
    assert numbers == sorted(numbers)
    assert len(numbers) > 2
    for seq, image in (shown[0], shown[len(shown) // 2], shown[-1]):
        path = f"{target.address}/api/scenes/{target.scene}/frame"
        alone = httpx.post(path, json=edits(seq), headers={"Accept": "image/png"})
        assert np.array_equal(
            np.frombuffer(image, np.uint8), np.frombuffer(alone.content, np.uint8)
        )
