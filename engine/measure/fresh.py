"""Products that are precomputed from nothing, so that their time is that of the whole work."""

from __future__ import annotations

import contextlib
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from engine.measure.timing import PhaseClock
from engine.methods import prepare
from engine.methods.base import Product, Progress, silent
from engine.scene.scene import Scene
from engine.store import Store


@dataclass(frozen=True)
class Fresh:
    """A product, the seconds of its precompute, and those of every phase of it."""

    product: Product
    seconds: float
    phases: dict[str, float]


@contextlib.contextmanager
def fresh(
    scene: Scene,
    method: str,
    settings: Any,
    progress: Progress = silent,
    store: Store | None = None,
) -> Iterator[Fresh]:
    """A product whose transport lies in a store that is thrown away at the end.

    With a `store` of one's own it stays there, and takes no time where it was there.
    """
    with tempfile.TemporaryDirectory(prefix="relight-fresh-") as folder:
        clock, start = PhaseClock(progress), time.perf_counter()
        product = prepare(scene, method, settings, clock, store=store or Store(Path(folder)))
        seconds = time.perf_counter() - start
        clock.stop()
        yield Fresh(product, seconds, clock.seconds)
