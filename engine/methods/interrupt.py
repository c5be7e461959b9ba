"""Frames that take long, and stop where nobody waits for them any more."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from engine.errors import Cancelled

Stop = Callable[[], bool]


def _never() -> bool:
    return False


_stop: ContextVar[Stop] = ContextVar("stop", default=_never)


@contextmanager
def interruptible(stop: Stop) -> Iterator[None]:
    """Let what a frame does in pieces raise `Cancelled` as soon as stop() says so."""
    token = _stop.set(stop)
    try:
        yield
    finally:
        _stop.reset(token)


def pieces(count: int, size: int) -> Iterator[slice]:
    """Slices of [0, count), in order. Raises Cancelled before one that nobody waits for."""
    for start in range(0, count, size):
        if _stop.get()():
            raise Cancelled("somebody wants another frame by now")
        yield slice(start, min(start + size, count))
