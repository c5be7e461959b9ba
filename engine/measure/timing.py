"""Times of calls that repeat, on a machine that also does other things."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np


@dataclass(frozen=True)
class Timing:
    """Wall-clock seconds of each repetition, in the order of the calls."""

    seconds: tuple[float, ...]

    @property
    def median(self) -> float:
        """Half of the calls were faster."""
        return float(np.median(self.seconds))

    @property
    def p95(self) -> float:
        """95 of 100 calls were faster."""
        return float(np.percentile(self.seconds, 95))


def stopwatch(call: Callable[[], Any]) -> float:
    """Seconds of one call."""
    start = time.perf_counter()
    call()
    return time.perf_counter() - start


def repeat(call: Callable[[], Any], count: int, warm_up: int = 1) -> Timing:
    """Time `count` calls after `warm_up` that do not count (compilation, caches)."""
    for _ in range(warm_up):
        call()
    return Timing(tuple(stopwatch(call) for _ in range(count)))


def paired_ratio(
    call: Callable[[], Any], other: Callable[[], Any], count: int, warm_up: int = 1
) -> tuple[float, float, float]:
    """(lower quartile, median, upper quartile) of time of `call` over time of `other`.

    The two take turns, so that a machine that slows down slows both; which goes first alternates.
    """
    for _ in range(warm_up):
        call()
        other()
    ratios = []
    for turn in range(count):
        if turn % 2:
            second = stopwatch(other)
            first = stopwatch(call)
        else:
            first = stopwatch(call)
            second = stopwatch(other)
        ratios.append(first / second)
    low, middle, high = np.percentile(ratios, [25, 50, 75])
    return float(low), float(middle), float(high)


class PhaseClock:
    """A `Progress` that notes how long each phase took, and passes everything on."""

    def __init__(self, onward: Callable[[str, float, float], None]) -> None:
        """The clock starts now; `onward` is another progress."""
        self._onward = onward
        self._phase, self._since = "", time.perf_counter()
        self.seconds: dict[str, float] = {}

    def __call__(self, phase: str, done: float, total: float) -> None:
        """See `engine.methods.base.Progress`."""
        if phase != self._phase:
            self.stop()
            self._phase = phase
        self._onward(phase, done, total)

    def stop(self) -> None:
        """Close the current phase."""
        now = time.perf_counter()
        if self._phase:
            self.seconds[self._phase] = self.seconds.get(self._phase, 0.0) + now - self._since
        self._phase, self._since = "", now
