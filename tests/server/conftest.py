"""A service over a tiny Cornell box, on a real port, with a store of its own."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import httpx
import pytest
import running
from fastapi import FastAPI

from engine.errors import BackendError
from engine.methods.base import Progress
from engine.methods.warm import compile_kernels
from engine.scene.builtin import cornell_box
from server.app import create_app
from server.precompute import Task

WIDTH, HEIGHT = 24, 18
QUICK = {"gather_samples": 1024, "coefficients": 30, "bounce_coefficients": 20}


@pytest.fixture(scope="session", autouse=True)
def own_store(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """Nothing of these tests touches the user's store."""
    folder = tmp_path_factory.mktemp("store")
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("RELIGHT_STORE", str(folder))
        yield folder


@pytest.fixture(scope="session", autouse=True)
def compiled() -> None:
    """No test waits for a compiler."""
    compile_kernels()


@pytest.fixture(scope="session")
def tiny_scene(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Cornell box at 24 x 18 pixels, as a file."""
    document = cornell_box.document()
    document["camera"] |= {"width": WIDTH, "height": HEIGHT}
    path = tmp_path_factory.mktemp("scenes") / "Tiny Box.json"
    path.write_text(json.dumps(document))
    return path


@pytest.fixture(scope="session")
def quick() -> dict[str, int]:
    """Settings with which the tiny scene is precomputed in no time."""
    return QUICK


@pytest.fixture(scope="session")
def serving() -> Callable[[FastAPI], AbstractContextManager[str]]:
    """`with serving(app) as address`."""
    return running.serving


def nothing(task: Task, progress: Progress) -> None:
    """A precompute that fails, so that frames stay direct."""
    raise BackendError("no precompute in this test")


@pytest.fixture(scope="session")
def client(tiny_scene: Path) -> Iterator[httpx.Client]:
    """HTTP, direct light only."""
    app = create_app([str(tiny_scene)], precompute=nothing, precompute_at_start=False)
    with running.serving(app) as address, httpx.Client(base_url=address, timeout=60) as client:
        yield client
