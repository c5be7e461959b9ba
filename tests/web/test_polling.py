"""Where a proxy lets no live socket through: frames by requests, and back once one opens."""

from __future__ import annotations

import asyncio
import contextlib
import json
import threading
import time
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page
from running import serving
from starlette.types import ASGIApp, Receive, Scope, Send
from web.test_page import INDIRECT, drag, light, settled

from engine.methods.base import Progress
from engine.scene.builtin import cornell_box
from server.app import create_app
from server.precompute import Task

pytestmark = pytest.mark.web

QUICK = {"gather_samples": 1024, "coefficients": 30, "bounce_coefficients": 20}
STATUS = "document.getElementById('status-connection').textContent"
# Numbers of all frames that were ever shown.
WATCH = """() => {
  window.shown = [];
  const canvas = document.getElementById('canvas');
  new MutationObserver(() => window.shown.push(Number(canvas.dataset.seq)))
    .observe(canvas, { attributeFilter: ['data-seq'] });
}"""


class Proxy:
    """Between page and service: blocks sockets, and holds up every other frame."""

    def __init__(self, app: ASGIApp) -> None:
        self.app = app
        self.blocks = "refused"  # or "silent", or ""
        self.under_way = self.most = self.frames = 0

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "websocket" and self.blocks == "silent":
            await receive()
            await receive()  # until the page gives up
        elif scope["type"] == "websocket" and self.blocks:
            await send({"type": "websocket.close"})
        elif scope["type"] == "http" and scope["path"].endswith("/frame"):
            self.frames += 1
            self.under_way += 1
            self.most = max(self.most, self.under_way)
            held = self.frames % 2 == 1
            try:
                await self.app(scope, receive, _later(send, 0.15) if held else send)
            finally:
                self.under_way -= 1
        else:
            await self.app(scope, receive, send)


def _later(send: Send, seconds: float) -> Send:
    async def later(message: Any) -> None:
        if message["type"] == "http.response.start":
            await asyncio.sleep(seconds)
        await send(message)

    return later


class Gate:
    """A precompute that waits to be let through; the product is made after it."""

    def __init__(self) -> None:
        self.open = threading.Event()

    def __call__(self, task: Task, progress: Progress) -> None:
        while not self.open.is_set():
            progress("final", 1, 4)
            time.sleep(0.02)


@pytest.fixture
def gate() -> Gate:
    return Gate()


@pytest.fixture
def proxy(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, gate: Gate) -> Proxy:
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path / "store"))
    document = cornell_box.document()
    document["camera"] |= {"width": 64, "height": 64}
    scene = tmp_path / "box.json"
    scene.write_text(json.dumps(document))
    app = create_app([str(scene)], precompute=gate, precompute_at_start=False, settings=QUICK)
    return Proxy(app)


def test_frames_by_requests_until_a_socket_opens(
    browser: Browser, proxy: Proxy, gate: Gate
) -> None:
    context = browser.new_context(viewport={"width": 1200, "height": 760})
    page: Page = context.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.clock.install()
    with serving(proxy) as address, contextlib.closing(context):
        page.goto(address)
        page.wait_for_selector("canvas[data-seq]", timeout=30_000)
        assert page.evaluate(STATUS) == "Connected, a request per frame"

        # The progress of the precompute, and its light once it is there.
        page.wait_for_selector("#progress:not([hidden])")
        page.wait_for_function(
            "() => document.getElementById('progress-text').textContent.includes('25 %')"
        )
        assert "direct light" in page.inner_text("#status-warnings").lower()
        gate.open.set()
        page.wait_for_function(INDIRECT)
        page.wait_for_selector("#progress", state="hidden")

        # Answers overtake each other; what is shown never goes back, and ends with the last edit.
        page.evaluate(WATCH)
        before = settled(page)
        light(page, "key")
        drag(page, "key", 150, 0)
        after = settled(page)
        assert abs(after - before).max() > 15
        shown = page.evaluate("window.shown")
        assert len(shown) > 3
        assert shown == sorted(shown)
        assert proxy.most == 2

        # Half a minute later it tries the socket again, and stays with it.
        proxy.blocks = ""
        page.clock.fast_forward(31_000)
        page.wait_for_function(f"() => {STATUS} === 'Connected'")
        frames = proxy.frames
        page.get_by_label("ceiling on").uncheck()
        assert abs(settled(page) - after).max() > 30
        assert proxy.frames == frames
        assert errors == []


def test_a_proxy_that_does_not_answer_is_not_waited_for(browser: Browser, proxy: Proxy) -> None:
    proxy.blocks = "silent"
    context = browser.new_context()
    page: Page = context.new_page()
    page.clock.install()
    with serving(proxy) as address, contextlib.closing(context):
        page.goto(address)
        page.wait_for_function("() => document.title.startsWith('box')")
        page.clock.fast_forward(5000)
        page.wait_for_selector("canvas[data-seq]", timeout=30_000)
        assert page.evaluate(STATUS) == "Connected, a request per frame"
