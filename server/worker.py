"""One render thread for all clients, and what it does for one frame."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from typing import Any, TypeVar

from engine.images import encode, encode_exr
from engine.methods.base import Frame
from engine.numerics.display import to_srgb8
from engine.scene.edits import Edits
from server.problems import Busy
from server.stage import METHOD, Stage, View
from server.wire import FrameHeader, ImageFormat, Notice

T = TypeVar("T")

MAX_WAITING = 64
MAX_NOTICES = 16


@dataclass(frozen=True)
class Order:
    """A frame that somebody wants."""

    edits: Edits
    exposure: float
    scale: int
    format: ImageFormat
    quality: int
    seq: int = 0
    method: str = METHOD
    settings: dict[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Drawn:
    """A frame as it leaves: header and encoded image."""

    header: FrameHeader
    image: bytes


class Worker:
    """The render thread: it owns everything that belongs to one thread, such as a GL context."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, "relight-render")
        self.waiting = 0

    async def run(self, work: Callable[[], T], *, always: bool = False) -> T:
        """Do `work` in the render thread, first come first served; Busy where too much waits.

        always  even then: for who waits for one piece of work at a time, and is one of few
        """
        if self.waiting >= MAX_WAITING and not always:
            raise Busy(f"{self.waiting} frames are waiting already")
        self.waiting += 1
        try:
            return await asyncio.get_running_loop().run_in_executor(self._pool, work)
        finally:
            self.waiting -= 1

    def close(self) -> None:
        """Finish the frame at hand, drop the rest."""
        self._pool.shutdown(wait=True, cancel_futures=True)


def view_of(stage: Stage, order: Order) -> View:
    """What draws the order; in the render thread alone."""
    edits, camera = order.edits, stage.camera(order.edits)
    return stage.view(camera, order.scale, order.method, edits.materials, order.settings)


def relit(stage: Stage, order: Order) -> tuple[Frame, str]:
    """The frame of an order, linear, and what drew it; in the render thread alone."""
    view = view_of(stage, order)
    return view.relight(order.edits), view.method


def draw(stage: Stage, order: Order) -> Drawn:
    """Relight, display and encode; in the render thread alone."""
    start = time.perf_counter()
    view = view_of(stage, order)
    prepared = time.perf_counter()
    frame = view.relight(order.edits)
    relit = time.perf_counter()
    if order.format == "exr":
        image = encode_exr(frame.image)
    else:
        shown = to_srgb8(frame.image, order.exposure)
        image = encode(shown, order.format, order.quality)
    end = time.perf_counter()
    parts = {name: seconds for name, seconds in frame.timings.items() if name != "total"}
    timings = {
        "buffer": prepared - start,
        **parts,
        "relight": relit - prepared,
        "encode": end - relit,
        "total": end - start,
    }
    height, width = frame.image.shape[:2]
    header = FrameHeader(
        seq=order.seq,
        width=width,
        height=height,
        scale=order.scale,
        format=order.format,
        method=view.method,
        timings={name: round(1000 * seconds, 2) for name, seconds in timings.items()},
        warnings=[Notice.of(warning) for warning in frame.warnings[:MAX_NOTICES]],
    )
    return Drawn(header, image)
