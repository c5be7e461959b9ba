"""Spread a kernel over the cores, from any thread.

Numba's own parallel loops abort the process when two threads start one at the same time unless a
particular threading layer is installed. Kernels here are therefore plain nogil loops over a range
of rows, and this module hands the ranges to a pool of threads. Results do not depend on the
number of threads because every row is computed by itself.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import Any

_worker = threading.local()


def thread_count() -> int:
    """Threads to use: RELIGHT_THREADS, or the cores this process may run on."""
    asked = os.environ.get("RELIGHT_THREADS", "")
    if asked.isdigit() and int(asked) > 0:
        return int(asked)
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def mark_worker() -> None:
    """Make loops of this thread run in it: for the threads of a pool that fills the cores."""
    _worker.inside = True


@cache
def _pool() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(thread_count(), "relight-kernel", initializer=mark_worker)


def for_ranges(
    body: Callable[..., Any], n: int, *args: Any, grain: int = 4096, align: int = 1
) -> None:
    """Call body(start, stop, *args) for ranges that cover [0, n) exactly once.

    `grain` is the least number of rows worth a call of its own, `align` a number that every start
    is a multiple of. Called from inside such a body, it runs in the calling thread. The first
    error of any range is raised here.
    """
    if n <= 0:
        return
    parts = min(4 * thread_count(), max(1, n // max(1, grain)))
    if parts == 1 or thread_count() == 1 or getattr(_worker, "inside", False):
        body(0, n, *args)
        return
    step = -(-n // parts)
    step = -(-step // align) * align
    futures = [
        _pool().submit(body, start, min(start + step, n), *args) for start in range(0, n, step)
    ]
    for future in futures:
        future.result()
