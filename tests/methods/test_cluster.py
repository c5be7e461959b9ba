"""Chunks on a Dask cluster: the same bytes, and a worker that is lost costs its chunk alone."""

from __future__ import annotations

import os
import pickle
import signal
import sys
import threading
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from typing import Any

import distributed
import pytest
from methods.small import digest, made

from engine.errors import InputError, RelightError
from engine.methods import METHODS, cluster

METHOD = "direct_to_indirect"


class Elsewhere(Executor):
    """As if each chunk were another process's: nothing gets there or back but pickled."""

    def __init__(self) -> None:
        self.chunks = 0

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Future:
        self.chunks += 1
        call = pickle.loads(pickle.dumps(partial(fn, *args, **kwargs)))
        future: Future = Future()
        future.set_result(pickle.loads(pickle.dumps(call())))
        return future


@pytest.fixture(scope="module")
def expected(tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Digests by method, of what this machine makes; filled as they are asked for."""

    class Made(dict[str, str]):
        def __missing__(self, method: str) -> str:
            self[method] = digest(made(method, tmp_path_factory.mktemp(method)))
            return self[method]

    return Made()


class Counting(distributed.SchedulerPlugin):
    """How often a worker has finished a chunk."""

    def __init__(self) -> None:
        self.finished = 0

    def transition(self, key: Any, start: str, finish: str, *args: Any, **kwargs: Any) -> None:
        self.finished += str(key).startswith("_run") and (start, finish) == ("processing", "memory")


@pytest.fixture(scope="module")
def two_workers() -> Iterator[distributed.LocalCluster]:
    """A scheduler in this process and two workers in theirs, on loopback."""
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=":0"
    ) as local:
        yield local


@pytest.mark.parametrize("method", sorted(METHODS.keys() - {METHOD}))
def test_chunks_can_be_sent(method: str, tmp_path: Path, expected: dict[str, str]) -> None:
    elsewhere = Elsewhere()
    assert digest(made(method, tmp_path, elsewhere)) == expected[method]
    assert elsewhere.chunks >= 1


@pytest.mark.sweep
def test_a_killed_worker_costs_its_chunk(
    two_workers: distributed.LocalCluster, tmp_path: Path, expected: dict[str, str]
) -> None:
    counting = Counting()
    two_workers.scheduler.add_plugin(counting, name="counting")
    killed: list[int] = []
    chunks: dict[str, float] = {}

    def kill(phase: str, done: float, total: float) -> None:
        chunks[phase] = total
        if phase == "final" and done >= 1 and not killed:
            killed.extend(pids.values())
            os.kill(killed[0], signal.SIGKILL)

    with cluster.cluster(two_workers.scheduler_address) as executor:
        pids = executor._client.run(os.getpid)  # type: ignore[attr-defined]
        assert len(set(pids.values()) - {os.getpid()}) == 2
        product = made(METHOD, tmp_path, executor, kill)
    assert killed
    assert digest(product) == expected[METHOD]
    # One that was lost is counted twice, if it was done and not fetched yet.
    asked = chunks["bounce"] + chunks["final"]
    assert asked >= 5
    assert asked <= counting.finished <= asked + 1


@pytest.mark.sweep
@pytest.mark.parametrize("method", METHODS)
def test_the_same_bytes_from_a_cluster(
    method: str,
    two_workers: distributed.LocalCluster,
    tmp_path: Path,
    expected: dict[str, str],
) -> None:
    with cluster.cluster(two_workers.scheduler_address) as executor:
        assert digest(made(method, tmp_path, executor)) == expected[method]
    assert digest(made(method, tmp_path)) == expected[method]


def test_other_sources_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    assert cluster._run(int, cluster.source_digest(), "7") == 7
    with pytest.raises(RelightError, match="another version of Relight"):
        cluster._run(int, "0123", "7")


def test_nobody_answers(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "SECONDS", 0.5)
    threads = set(threading.enumerate())
    for address in ("tcp://127.0.0.1:9", "nonsense://x", "127.0.0.1:none"):
        with (
            pytest.raises(InputError, match="no Dask scheduler answers") as caught,
            cluster.cluster(address),
        ):
            pass
        assert caught.value.field == "scheduler"
    # A client that is left behind hangs what comes after it, now and then.
    assert set(threading.enumerate()) <= threads


def test_nobody_works(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cluster, "SECONDS", 0.5)
    with (
        distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address=":0") as empty,
        pytest.raises(InputError, match="has no workers"),
        cluster.cluster(empty.scheduler_address),
    ):
        pass


def test_a_scheduler_that_is_lost(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One sentence in place of what Dask raises."""
    monkeypatch.setattr(cluster, "SECONDS", 2.0)
    local = distributed.LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, protocol="tcp://", host="127.0.0.1",
        dashboard_address=":0",
    )  # fmt: skip

    def close(phase: str, done: float, total: float) -> None:
        if done > 0 and phase == "bounce":
            local.close()

    with (
        local,
        pytest.raises(RelightError, match=r"was lost .*the same command goes on"),
        cluster.cluster(local.scheduler_address) as executor,
    ):
        made(METHOD, tmp_path, executor, close)


def test_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    from engine.cli import _executor

    monkeypatch.delitem(sys.modules, "engine.methods.cluster")
    for name in ("dask", "distributed"):
        monkeypatch.setitem(sys.modules, name, None)
    with pytest.raises(RelightError, match=r"pip install 'relight\[cluster\]'"):
        _executor("tcp://127.0.0.1:9")
