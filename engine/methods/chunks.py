"""Run a chunked job on an executor; finished chunks land in the store, a restart takes them up."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from engine.methods.base import Progress
from engine.numerics.parallel import thread_count
from engine.store import Entry

IN_FLIGHT = max(8, 2 * thread_count())  # chunks handed out at a time, where an executor has no say

Arrays = dict[str, NDArray[Any]]


class CallingThread(Executor):
    """Does at once what is submitted: for work that belongs to the thread that asks for it."""

    in_flight = 1  # so that progress is told

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """A future that is done."""
        done: Future[Any] = Future()
        try:
            done.set_result(fn(*args, **kwargs))
        except Exception as error:
            done.set_exception(error)
        return done


@threadpool_limits.wrap(limits=1, user_api="blas")
def run_chunks(
    work: Callable[[int], Arrays],
    chunks: int,
    phase: str,
    entry: Entry,
    executor: Executor,
    progress: Progress,
) -> Arrays:
    """The arrays of work(0), work(1), ... work(chunks - 1), joined along their first axis in order.

    Matrix products keep to one thread meanwhile: chunks fill the cores, and their bits then do not
    depend on how many there are.

    Raises whatever `progress` or a chunk raises, after asking what still waits not to start; the
    chunks that have finished by then stay in `entry`.
    """
    parts: dict[int, Arrays] = {}
    for chunk in range(chunks):
        stored = entry.read(f"{phase}-{chunk}")
        if stored is not None:
            parts[chunk] = stored.arrays
    missing = [chunk for chunk in range(chunks) if chunk not in parts]
    progress(phase, len(parts), chunks)
    running: dict[Future[Arrays], int] = {}
    most: int = getattr(executor, "in_flight", IN_FLIGHT)
    try:
        while missing or running:
            while missing and len(running) < most:
                chunk = missing.pop(0)
                running[executor.submit(work, chunk)] = chunk
            done, _ = wait(running, timeout=0.2, return_when=FIRST_COMPLETED)
            for future in done:
                chunk = running.pop(future)
                parts[chunk] = future.result()
                entry.write(f"{phase}-{chunk}", parts[chunk], {})
            progress(phase, len(parts), chunks)
    finally:
        for future in running:
            future.cancel()
    return {
        name: np.concatenate([parts[chunk][name] for chunk in range(chunks)]) for name in parts[0]
    }
