"""The real service in a process of its own, and a real headless Chromium."""

from __future__ import annotations

import contextlib
import json
import os
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, sync_playwright

from engine.methods.warm import compile_kernels
from engine.scene.builtin import cornell_box

ROOT = Path(__file__).resolve().parents[2]
ARGS = [
    "--no-sandbox",
    "--disable-gpu",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--disable-default-apps",
]
SIZE = 128
SERVE = """
import sys, json
import server.main, server.app
make = server.app.create_app
settings = json.loads(sys.argv[2])
server.main.create_app = lambda scenes, **rest: make(scenes, settings=settings, **rest)
server.main.serve([sys.argv[1]], port=0)
"""


@contextlib.contextmanager
def serve(scene: Path, store: Path, settings: dict[str, int]) -> Iterator[str]:
    """`relight serve SCENE --port 0` with other settings of the method; its address."""
    process = subprocess.Popen(
        [sys.executable, "-c", SERVE, str(scene), json.dumps(settings)],
        cwd=ROOT,
        env={**os.environ, "RELIGHT_STORE": str(store)},
        stdout=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    try:
        line = process.stdout.readline()
        address = re.search(r"http://\S+", line)
        assert address, f"the service printed {line!r} and no address"
        yield address[0]
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=60)
        process.stdout.close()


@pytest.fixture(scope="session")
def scene_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The Cornell box, small."""
    document = cornell_box.document()
    document["camera"] |= {"width": SIZE, "height": SIZE}
    path = tmp_path_factory.mktemp("scene") / "box.json"
    path.write_text(json.dumps(document))
    return path


@pytest.fixture(scope="session")
def address(scene_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """One service for all modules but those that want a fresh one: see `fresh`."""
    with fresh(scene_file, tmp_path_factory.mktemp("store")) as address:
        yield address


def fresh(scene_file: Path, store: Path) -> AbstractContextManager[str]:
    """A service that has precomputed nothing yet."""
    return serve(scene_file, store, {"gather_samples": 4096})


@pytest.fixture(scope="session", autouse=True)
def compiled() -> None:
    """No test waits for a compiler."""
    compile_kernels()


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    path = shutil.which("chromium") or shutil.which("chromium-browser")
    if path is None:
        pytest.fail("no Chromium: `make test` installs it")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=ARGS)
        yield browser
        browser.close()


@dataclass
class Visit:
    """A page, and everything that went wrong on it."""

    page: Page
    errors: list[str] = field(default_factory=list)
    hosts: set[str] = field(default_factory=set)


def _note(visit: Visit, message: ConsoleMessage) -> None:
    if message.type in ("error", "warning"):
        visit.errors.append(message.text)


@contextlib.contextmanager
def _visiting(browser: Browser, address: str, **options: object) -> Iterator[Visit]:
    """Open the page and wait for first pixels; an error in its console fails the test."""
    context = browser.new_context(viewport={"width": 1200, "height": 760}, **options)  # type: ignore[arg-type]
    visit = Visit(context.new_page())
    page = visit.page
    page.on("pageerror", lambda error: visit.errors.append(str(error)))
    page.on("console", lambda message: _note(visit, message))
    page.on("request", lambda request: visit.hosts.add(urlsplit(request.url).hostname or "blob"))
    page.on("websocket", lambda socket: visit.hosts.add(urlsplit(socket.url).hostname or ""))
    page.goto(address)
    page.wait_for_selector("canvas[data-seq]", timeout=90_000)
    yield visit
    context.close()
    assert visit.errors == []
    assert visit.hosts <= {"127.0.0.1", "blob"}


@pytest.fixture
def visit(browser: Browser, address: str) -> Iterator[Visit]:
    with _visiting(browser, address) as visit:
        yield visit


@pytest.fixture
def visiting() -> Callable[..., AbstractContextManager[Visit]]:
    """`with visiting(browser, address, **options) as visit`."""
    return _visiting
