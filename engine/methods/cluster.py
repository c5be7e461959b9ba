"""Chunks on a Dask cluster, through its Executor: the same calls on other machines.

What the chunks of a job share, its arrays and all, is sent once. It is a task of its own, so that a
worker that lacks it has it from another, and that it is made again where all who had it are gone.
Workers need no disk in common with this process: what they make comes back and lands in the store
here. They need the same sources, and run each chunk as a thread of a local pool does.
"""

from __future__ import annotations

import asyncio
import contextlib
import pickle
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, Executor, Future
from functools import cache
from typing import Any

import dask
import distributed
from distributed.comm import CommClosedError
from distributed.scheduler import KilledWorker
from threadpoolctl import threadpool_limits

from engine._cache import source_digest
from engine.errors import InputError, RelightError
from engine.methods.chunks import IN_FLIGHT
from engine.numerics.parallel import mark_worker

SECONDS = 10.0  # to wait for a scheduler, and for one worker at least


class ClusterExecutor(Executor):
    """Dask's Executor, which gets what is called with every chunk sent but once."""

    def __init__(self, client: Any) -> None:
        self._client, self._executor = client, client.get_executor(pure=False)
        self._sent: tuple[Callable[..., Any] | None, Any] = (None, None)
        # Chunks to hand out at a time: workers should not wait for the next.
        self.in_flight = max(IN_FLIGHT, 2 * sum(client.nthreads().values()))

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """See `concurrent.futures`; a call may run twice, where its first worker was lost."""
        if self._sent[0] is not fn:
            # Arrays in a task's description can be sent again, unlike those that are scattered.
            with dask.config.set({"distributed.admin.large-graph-warning-threshold": "1TiB"}):
                self._sent = fn, self._client.submit(pickle.loads, pickle.dumps(fn), pure=False)
        future: Future[Any] = self._executor.submit(
            _run, self._sent[1], source_digest(), *args, **kwargs
        )
        return future


@contextlib.contextmanager
def cluster(address: str) -> Iterator[Executor]:
    """The executor of the cluster whose scheduler answers at an address, `tcp://host:8786`.

    Raises InputError for an address that nobody answers at or that has no workers, RelightError,
    in place of what Dask raises, where the cluster is lost in the middle.
    """
    try:
        asyncio.run(_knock(address))
        client = distributed.Client(address, timeout=SECONDS, set_as_default=False)
    except (OSError, ValueError) as error:
        raise InputError(
            f"no Dask scheduler answers at {address!r}: {error}; `dask scheduler` starts one and "
            "prints its address",
            field="scheduler",
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=SECONDS)
        except TimeoutError:
            raise InputError(
                f"the Dask scheduler at {address!r} has no workers after {SECONDS:.0f} s; "
                f"`dask worker {address}` starts one, where Relight is installed",
                field="scheduler",
            ) from None
        try:
            yield ClusterExecutor(client)
        except (CancelledError, CommClosedError, KilledWorker) as error:
            raise RelightError(
                f"the cluster at {address!r} was lost ({error or type(error).__name__}); chunks "
                "that were finished are kept: the same command goes on from there"
            ) from error
        except ModuleNotFoundError as error:
            raise RelightError(
                f"a worker at {address!r} has no {error.name}; install Relight there too"
            ) from error


async def _knock(address: str) -> None:
    """Raise what a client would that finds nobody.

    That client would stay: its thread goes on, and it waits for other clients' locks when Python
    clears it away, in whatever thread does so, which can be the one that holds up those locks.
    """
    comm = await distributed.comm.connect(address, timeout=SECONDS)
    await comm.close()


def _run(work: Callable[..., Any], digest: str, *args: Any, **kwargs: Any) -> Any:
    """One call, on a worker."""
    if digest != source_digest():
        raise RelightError("a worker has another version of Relight, which might compute otherwise")
    mark_worker()
    _limit()
    return work(*args, **kwargs)


@cache
def _limit() -> threadpool_limits:
    """Matrix products keep to one thread from now on, see `chunks`."""
    return threadpool_limits(limits=1, user_api="blas")
