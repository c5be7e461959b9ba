"""Many scenes and clients with little memory: what is let go is loaded again, frames stay right."""

from __future__ import annotations

import json
import os
import re
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import httpx
import pytest
from fastapi import FastAPI

from engine.errors import BackendError
from engine.methods import prepare
from engine.methods.base import Product, Progress
from engine.scene.builtin import cornell_box
from engine.scene.open import open_scene
from server.app import create_app
from server.precompute import Task, settings_of

Serving = Callable[[FastAPI], AbstractContextManager[str]]
Pictures = dict[tuple[int, int, str], bytes]

CLIENTS = 3
PLACES = [{"lights": [{"id": "key", "position": [0.1 * k, 0.3, 0.2]}]} for k in (1, 4)]
GROWTH = 24e6  # bytes that a process may come to hold meanwhile, of which the allocator has some


def never(task: Task, progress: Progress) -> None:
    """Frames stay direct."""
    raise BackendError("no precompute in this test")


def in_place(task: Task, progress: Progress) -> None:
    """As `run_in_process`, without a process."""
    scene = open_scene(task.source).with_camera(task.camera)
    prepare(scene, task.method, settings_of(task.method, task.settings), progress)


@pytest.fixture(scope="module")
def boxes(tmp_path_factory: pytest.TempPathFactory) -> list[str]:
    """Cornell boxes of other colours, a client each."""
    folder, paths = tmp_path_factory.mktemp("boxes"), []
    for k in range(CLIENTS):
        document = cornell_box.document()
        document["camera"] |= {"width": 24, "height": 18 + 2 * k}
        paths.append(folder / f"box {k}.json")
        paths[-1].write_text(json.dumps(document))
    return [str(path) for path in paths]


@pytest.fixture(scope="module")
def right(boxes: list[str], serving: Serving, quick: dict[str, int]) -> tuple[Pictures, float]:
    """Every picture, direct and whole, of services with room for all; bytes of the products."""
    pictures: Pictures = {}
    every = [(k, place) for k in range(CLIENTS) for place in range(len(PLACES))]
    for precompute in (never, in_place):
        app = create_app(boxes, precompute=precompute, precompute_at_start=False, settings=quick)
        with serving(app) as address, httpx.Client(base_url=address, timeout=60) as client:
            if precompute is in_place:
                until(lambda: all(frame(client, k, 0)[0] != "direct" for k in range(CLIENTS)))
            for k, place in every:
                method, picture = frame(client, k, place)
                pictures[k, place, method] = picture
            bytes_of_all = kept(client)
    assert len(pictures) == 2 * len(every) == len(set(pictures.values()))
    return pictures, bytes_of_all


def frame(client: httpx.Client, k: int, place: int) -> tuple[str, bytes]:
    """(what drew it, a lossless picture) of scene k under an edit."""
    answer = client.post(
        f"/api/scenes/box-{k}/frame", json=PLACES[place], headers={"Accept": "image/png"}
    )
    assert answer.status_code == 200, answer.text
    header: dict[str, Any] = json.loads(answer.headers["Relight-Frame"])
    return header["method"], answer.content


def kept(client: httpx.Client) -> float:
    """Bytes of products that the service has at hand."""
    found = re.search(r"^relight_product_bytes (\S+)$", client.get("/metrics").text, re.MULTILINE)
    assert found, "no such metric"
    return float(found[1])


def until(true: Callable[[], bool], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "it never became true"
        time.sleep(0.01)


def resident() -> int:
    """Bytes of memory that this process has."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def alternate(
    boxes: list[str], right: tuple[Pictures, float], serving: Serving, quick: dict[str, int],
    rounds: int,
) -> list[int]:  # fmt: skip
    """Clients that each want whole pictures of their own scene, with room for half of the products.

    Returns the memory of the process after every round.
    """
    pictures, bytes_of_all = right
    loaded: list[Task] = []
    memory: list[int] = []

    app = create_app(
        boxes, precompute=in_place, precompute_at_start=False, settings=quick,
        memory=bytes_of_all / 2,
    )  # fmt: skip
    for stage in app.state.service.stages.stages.values():

        def install(task: Task, product: Product, install: Any = stage.install) -> None:
            loaded.append(task)
            install(task, product)

        stage.install = install
    wrong: list[tuple[int, int, str]] = []

    def work(address: str, k: int) -> None:
        with httpx.Client(base_url=address, timeout=60) as client:
            for _ in range(rounds):
                for place in range(len(PLACES)):
                    together.wait(60)
                    method = "direct"
                    end = time.monotonic() + 60
                    while method == "direct" and time.monotonic() < end:
                        method, picture = frame(client, k, place)
                        if picture != pictures[k, place, method]:
                            wrong.append((k, place, method))
                    whole[k] += method != "direct"
                if k == 0:
                    memory.append(resident())
                assert kept(client) <= bytes_of_all / 2

    whole, together = [0] * CLIENTS, threading.Barrier(CLIENTS)
    with serving(app) as address, ThreadPoolExecutor(CLIENTS) as threads:
        for done in [threads.submit(work, address, k) for k in range(CLIENTS)]:
            done.result()
    assert wrong == []
    assert whole == [rounds * len(PLACES)] * CLIENTS
    assert len(loaded) > CLIENTS, "nothing had to be let go"
    return memory


def test_with_room_for_half_of_the_products_all_pictures_are_right(
    boxes: list[str], right: tuple[Pictures, float], serving: Serving, quick: dict[str, int]
) -> None:
    alternate(boxes, right, serving, quick, rounds=1)


@pytest.mark.sweep
def test_and_memory_stays_as_it_is(
    boxes: list[str], right: tuple[Pictures, float], serving: Serving, quick: dict[str, int]
) -> None:
    memory = alternate(boxes, right, serving, quick, rounds=60)
    assert memory[-1] - memory[len(memory) // 4] < GROWTH
