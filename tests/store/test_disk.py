"""A disk that is full or may not be written: what is said, and what stands there afterwards."""

from __future__ import annotations

import errno
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from store.full import Disk

from engine.errors import StoreError
from engine.store import Entry, Store, folder

OLD, NEW = np.arange(500), np.arange(500, 1000)


def refuses(number: int) -> Any:
    def refuse(*args: Any, **kwargs: Any) -> Any:
        raise OSError(number, os.strerror(number))

    return refuse


@pytest.fixture
def entry(tmp_path: Path) -> Entry:
    entry = Store(tmp_path).entry("k")
    entry.write("x", {"a": OLD}, {})
    return entry


def old_is_there(entry: Entry, tmp_path: Path) -> bool:
    found = entry.read("x")
    files = [path.name for path in (tmp_path / "k").iterdir()]
    return found is not None and np.array_equal(found.arrays["a"], OLD) and files == ["x.relight"]


@pytest.mark.parametrize("step", ["mkdir", "create", "sync", "rename"])
@pytest.mark.parametrize("number", [errno.ENOSPC, errno.EROFS, errno.EDQUOT, errno.EIO])
def test_every_step_may_fail(
    entry: Entry, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, step: str, number: int
) -> None:
    of, name = {
        "mkdir": (Path, "mkdir"),
        "create": (folder.tempfile, "NamedTemporaryFile"),
        "sync": (os, "fsync"),
        "rename": (Path, "replace"),
    }[step]
    with monkeypatch.context() as patch:
        patch.setattr(of, name, refuses(number))
        with pytest.raises(StoreError, match=os.strerror(number)) as caught:
            entry.write("x", {"a": NEW}, {})
    assert "RELIGHT_STORE" in caught.value.message
    assert str(tmp_path) not in caught.value.message
    assert str(tmp_path) in str(caught.value)
    assert old_is_there(entry, tmp_path)


def test_the_disk_may_be_full_after_any_byte(
    entry: Entry, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = entry.size
    for room in range(0, whole - 64, 97):
        with monkeypatch.context() as patch:
            Disk(room).install(patch)
            with pytest.raises(StoreError, match="No space left"):
                entry.write("x", {"a": NEW, "b": NEW}, {})
        assert old_is_there(entry, tmp_path)


def test_what_may_not_be_removed_is_passed_over(
    entry: Entry, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "k" / "x.relight"
    path.write_bytes(path.read_bytes()[:-9])
    monkeypatch.setattr(Path, "unlink", refuses(errno.EROFS))
    assert entry.read("x") is None
    assert path.exists()


def test_what_cannot_be_read_is_said(
    entry: Entry, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(Path, "open", refuses(errno.EIO))
    with pytest.raises(StoreError, match="cannot be read: "):
        entry.read("x")
