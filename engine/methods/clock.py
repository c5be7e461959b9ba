"""Where the time of a frame goes."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Clock:
    """Seconds by part, each until `finish` returns."""

    def __init__(self, finish: Callable[[], object] = lambda: None) -> None:
        self._finish = finish
        self._start = time.perf_counter()
        self._parts: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time what is done within as the part `name`."""
        start = time.perf_counter()
        yield
        self._finish()
        self._parts[name] = time.perf_counter() - start

    def timings(self) -> dict[str, float]:
        """Seconds of every part, and `total` since the clock was made."""
        return {**self._parts, "total": time.perf_counter() - self._start}
