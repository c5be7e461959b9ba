"""A precompute that is killed, has no disk left or finds damaged files comes to the same bytes.

Few of each here; fifty of each of every method by `make sweep`.
"""

from __future__ import annotations

import errno
import logging
import multiprocessing
import os
import shutil
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from methods.small import digest, made
from store.full import Disk

from engine.errors import StoreError
from engine.methods import METHODS

LARGE = 1 << 40  # bytes
FEW = [pytest.param("direct_to_indirect", 2)]
MANY = [pytest.param(method, 50, marks=pytest.mark.sweep) for method in METHODS]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Path, str]]:
    """(store, digest of its product) by method, undisturbed; filled as they are asked for."""

    class Made(dict[str, tuple[Path, str]]):
        def __missing__(self, method: str) -> tuple[Path, str]:
            folder = tmp_path_factory.mktemp(method)
            self[method] = folder, digest(made(method, folder))
            return self[method]

    return Made()


def files(folder: Path) -> list[Path]:
    return sorted(folder.rglob("*.relight"))


def work(method: str, folder: str, said: Any) -> None:
    said.send("started")
    said.send(digest(made(method, folder)))


class Child:
    """A process that precomputes."""

    def __init__(self, method: str, folder: Path) -> None:
        # Forked from a process that has loaded the engine and runs no threads: it starts at once.
        context = multiprocessing.get_context("forkserver")
        context.set_forkserver_preload(["engine.methods", "engine.scene.open"])
        self._heard, said = context.Pipe(duplex=False)
        self._process = context.Process(target=work, args=(method, str(folder), said))
        self._process.start()
        said.close()
        assert self._heard.recv() == "started"
        self._start = time.monotonic()

    def digest(self, seconds: float = 120) -> str | None:
        """What it made; None where it has not by then, and is killed."""
        there = self._heard.poll(max(0.0, self._start + seconds - time.monotonic()))
        found = self._heard.recv() if there else None
        self.took = time.monotonic() - self._start
        self._process.kill()
        self._process.join()
        self._heard.close()
        return found


@pytest.mark.parametrize(("method", "times"), MANY)
def test_killed(
    method: str, times: int, tmp_path: Path, whole: dict[str, tuple[Path, str]]
) -> None:
    """kill -9 at random points: every start goes on from what is there."""
    _, expected = whole[method]
    undisturbed = Child(method, tmp_path / "first")
    assert undisturbed.digest() == expected
    kills, finished, random = 0, 0, np.random.default_rng(1)
    folder = tmp_path / "store"
    while kills < times:
        found = Child(method, folder).digest(random.uniform(0, undisturbed.took))
        if found is None:
            kills += 1
            continue
        assert found == expected
        finished += 1
        shutil.rmtree(folder)
    assert digest(made(method, folder)) == expected
    print(f"{method}: {kills} kills, {finished} runs came to their end in between")


@pytest.mark.parametrize(("method", "times"), [*FEW, *MANY])
def test_a_full_disk(
    method: str,
    times: int,
    tmp_path: Path,
    whole: dict[str, tuple[Path, str]],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It is full after some byte: a sentence, and with room again the same bytes."""
    _, expected = whole[method]
    with monkeypatch.context() as patch:
        disk = Disk(LARGE)
        disk.install(patch)
        made(method, tmp_path / "large")
    for k, room in enumerate(np.random.default_rng(2).integers(0, LARGE - disk.room, times)):
        with monkeypatch.context() as patch:
            Disk(int(room)).install(patch)
            with pytest.raises(StoreError, match="No space left on device; RELIGHT_STORE"):
                made(method, tmp_path / str(k))
        assert not list((tmp_path / str(k)).rglob("*.part"))
        assert digest(made(method, tmp_path / str(k))) == expected
        shutil.rmtree(tmp_path / str(k))


@pytest.fixture
def read_only(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Nothing may be written or removed; permissions would not keep root from it."""

    def refuse(*args: Any, **kwargs: Any) -> None:
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    for name in ("mkdir", "unlink", "replace"):
        monkeypatch.setattr(Path, name, refuse)
    monkeypatch.setattr("engine.store.folder.tempfile.NamedTemporaryFile", refuse)
    monkeypatch.setattr(os, "unlink", refuse)
    monkeypatch.setattr(os, "rmdir", refuse)
    yield
    monkeypatch.undo()


@pytest.mark.parametrize("method", METHODS)
def test_a_store_to_be_read_alone(
    method: str, whole: dict[str, tuple[Path, str]], request: pytest.FixtureRequest
) -> None:
    folder, expected = whole[method]
    request.getfixturevalue("read_only")
    assert digest(made(method, folder)) == expected


def test_what_a_read_only_store_lacks(
    tmp_path: Path, whole: dict[str, tuple[Path, str]], request: pytest.FixtureRequest
) -> None:
    folder, _ = whole["direct_to_indirect"]
    shutil.copytree(folder, tmp_path / "store")
    damaged = next(path for path in files(tmp_path / "store") if path.stem == "final")
    damaged.write_bytes(damaged.read_bytes()[:-100])
    request.getfixturevalue("read_only")
    with pytest.raises(StoreError, match="cannot be written: Read-only file system"):
        made("direct_to_indirect", tmp_path / "store")


@pytest.mark.parametrize(("method", "times"), [*FEW, *MANY])
def test_damaged_files(
    method: str,
    times: int,
    tmp_path: Path,
    whole: dict[str, tuple[Path, str]],
    caplog: pytest.LogCaptureFixture,
) -> None:
    """A file is cut, or one of its bits is another: it is made again."""
    caplog.set_level(logging.ERROR)
    folder, expected = whole[method]
    shutil.copytree(folder, tmp_path / "store")
    random = np.random.default_rng(3)
    for k in range(times):
        there = files(tmp_path / "store")
        path = there[random.integers(len(there))]
        data = bytearray(path.read_bytes())
        place = int(random.integers(len(data)))
        if k % 2:
            del data[place:]
        else:
            data[place] ^= 1 << int(random.integers(8))
        path.write_bytes(data)
        assert digest(made(method, tmp_path / "store")) == expected, (path.name, place)
        assert files(tmp_path / "store") == there
