"""A store on a file system of fsspec does what one in a folder does."""

from __future__ import annotations

import mmap
import sys
import uuid
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from store.mapped import mapping_under

from engine.doctor import examine
from engine.errors import RelightError, StoreError
from engine.store import Entry, Store
from engine.store.folder import FolderEntry
from engine.store.remote import RemoteEntry

ARRAYS = {"a": np.arange(600, dtype=np.int16), "b": np.linspace(0, 1, 3, dtype=np.float32)}


@pytest.fixture
def copies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "relight" / "copies"


@pytest.fixture(params=["memory", "local"])
def store(request: pytest.FixtureRequest, copies: Path, tmp_path: Path) -> Store:
    """In memory, and in a folder by way of fsspec."""
    there = f"/{uuid.uuid4()}" if request.param == "memory" else tmp_path / "there"
    return Store(f"{request.param}://{there}")


@pytest.fixture
def entry(store: Store) -> RemoteEntry:
    made = store.entry("0123abcd")
    assert isinstance(made, RemoteEntry)
    return made


def change(entry: RemoteEntry, name: str, how: Any) -> None:
    """Change the bytes of a file in the store."""
    path = f"{entry.folder}/{name}.relight"
    entry.files.pipe_file(path, how(entry.files.cat_file(path)))


def same(entry: Entry, name: str, arrays: dict[str, np.ndarray], meta: dict[str, Any]) -> bool:
    found = entry.read(name)
    return (
        found is not None
        and found.meta == meta
        and all(np.array_equal(found.arrays[k], a) for k, a in arrays.items())
    )


def test_it_gives_back_what_was_put_in(entry: RemoteEntry) -> None:
    assert entry.names() == []
    assert entry.size == 0
    assert entry.read("x") is None
    entry.remove()
    entry.write("x", ARRAYS, {"settings": {"bounces": 3}})
    entry.write("b.0", {}, {})
    assert same(entry, "x", ARRAYS, {"settings": {"bounces": 3}})
    assert entry.names() == ["b.0", "x"]
    assert 1200 < entry.size < 4000
    entry.remove()
    assert entry.names() == []
    assert entry.read("x") is None
    assert not entry.copies.exists()


def test_copies_are_mapped_and_private(entry: RemoteEntry) -> None:
    entry.write("x", ARRAYS, {})
    for _ in range(2):  # as it is downloaded, and from the copy
        found = entry.read("x")
        assert found is not None
        assert isinstance(mapping_under(found.arrays["a"]), mmap.mmap)
        found.arrays["a"][:] = 7
    assert same(entry, "x", ARRAYS, {})
    (copy,) = (path for path in entry.copies.rglob("*") if path.is_file())
    assert copy.suffix == ".relight"


def test_a_copy_is_downloaded_once(entry: RemoteEntry, monkeypatch: pytest.MonkeyPatch) -> None:
    entry.write("x", ARRAYS, {})
    downloads: list[str] = []
    get = type(entry.files).get_file
    monkeypatch.setattr(
        type(entry.files), "get_file", lambda *args: (downloads.append(args[1]), get(*args))[1]
    )
    for _ in range(3):
        assert same(entry, "x", ARRAYS, {})
    assert len(downloads) == 1


def test_a_newer_file_is_not_taken_for_its_old_copy(entry: RemoteEntry) -> None:
    for k in range(3):
        entry.write("x", {"a": np.full(10 + k, k)}, {"k": k})
        assert same(entry, "x", {"a": np.full(10 + k, k)}, {"k": k})
    assert len([path for path in entry.copies.rglob("*") if path.is_file()]) == 1


@pytest.mark.parametrize(
    "damage",
    [
        lambda whole: whole[: len(whole) // 2],
        lambda whole: whole[:3],
        lambda whole: whole[:-90] + bytes([whole[-90] ^ 4]) + whole[-89:],
    ],
    ids=["half", "three bytes", "a bit"],
)
@pytest.mark.parametrize("copied", [False, True])
def test_what_is_damaged_is_absent(entry: RemoteEntry, damage: Any, copied: bool) -> None:
    entry.write("x", {"a": ARRAYS["a"]}, {})
    if copied:
        assert entry.read("x") is not None
    change(entry, "x", damage)
    assert entry.read("x") is None
    assert entry.names() == []
    entry.write("x", ARRAYS, {})
    assert same(entry, "x", ARRAYS, {})


def test_a_damaged_copy_is_downloaded_again(entry: RemoteEntry) -> None:
    entry.write("x", ARRAYS, {})
    assert entry.read("x") is not None
    (copy,) = (path for path in entry.copies.rglob("*") if path.is_file())
    copy.write_bytes(copy.read_bytes()[:-100])
    assert same(entry, "x", ARRAYS, {})
    assert same(entry, "x", ARRAYS, {})


def test_what_the_store_refuses_is_said(
    entry: RemoteEntry, monkeypatch: pytest.MonkeyPatch
) -> None:
    entry.write("x", ARRAYS, {"k": 1})

    def refuse(*args: Any, **kwargs: Any) -> None:
        raise ConnectionResetError("the line is dead")

    for name in ("put_file", "get_file"):
        monkeypatch.setattr(type(entry.files), name, refuse)
    with pytest.raises(StoreError, match="cannot be written: the line is dead; RELIGHT_STORE"):
        entry.write("x", ARRAYS, {"k": 2})
    with pytest.raises(StoreError, match="cannot be read: the line is dead"):
        entry.read("x")
    monkeypatch.undo()
    assert same(entry, "x", ARRAYS, {"k": 1})
    assert not list(entry.copies.rglob("*.part"))


def test_a_file_url_is_the_folder_itself(tmp_path: Path) -> None:
    store = Store(f"file://{tmp_path}/with%20space")
    assert store.entry("k") == FolderEntry(tmp_path / "with space" / "k")
    assert store.where == str(tmp_path / "with space")


def test_the_doctor_tries_it(store: Store) -> None:
    (found,) = (each for each in examine(store) if each.what == "store")
    assert found.state != "broken"
    assert store.where in found.says


def test_no_password_is_shown(copies: Path) -> None:
    assert Store("memory://me:secret@there/x").where == "memory://there/x"


@pytest.mark.parametrize(
    ("url", "package", "said"),
    [
        ("memory://x", "fsspec", r"pip install 'relight\[cluster\]'"),
        ("s3://bucket/x", "s3fs", "s3fs"),
        ("nothing://x", "", "RELIGHT_STORE cannot be opened: .*nothing"),
    ],
)
def test_what_is_missing_is_said(
    url: str, package: str, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    if package:
        monkeypatch.setitem(sys.modules, package, None)
    monkeypatch.setenv("RELIGHT_STORE", url)
    with pytest.raises(RelightError, match=said):
        Store()
