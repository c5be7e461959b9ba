"""The store gives back what was put in, or says that there is nothing."""

from __future__ import annotations

import logging
import mmap
import os
import signal
import struct
import subprocess
import sys
import threading
import time
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest
from store.mapped import mapping_under

from engine import store
from engine.errors import InputError, StoreError
from engine.store import Entry, Store
from engine.store.format import ALIGNMENT, VERSION

DTYPES = ["?", "i1", "u1", "<i2", "<i4", "<u8", "<f2", "<f4", "<f8", ">f4", ">i8", "<c8"]
SHAPES = [(), (0,), (3, 0, 2), (1,), (7,), (5, 3), (2, 3, 4, 5)]


@pytest.fixture
def entry(tmp_path: Path) -> Entry:
    return Store(tmp_path).entry("0123abcd")


def small(entry: Entry) -> Path:
    """A stored file of a few hundred bytes with two arrays and meta."""
    arrays = {"a": np.arange(5, dtype=np.int16), "b": np.linspace(0, 1, 3, dtype=np.float32)}
    entry.write("small", arrays, {"settings": {"bounces": 3}})
    return entry.folder / "small.relight"


def test_public_list() -> None:
    assert store.__all__ == ["Entry", "Store", "Stored"]


@pytest.mark.parametrize("dtype", DTYPES)
def test_round_trip(entry: Entry, dtype: str) -> None:
    rng = np.random.default_rng(7)
    arrays = {
        f"a{k}": np.asarray(rng.random(shape) * 100).astype(dtype) for k, shape in enumerate(SHAPES)
    }
    entry.write("x", arrays, {"shapes": len(SHAPES), "nested": {"π": [1.5, None, "é"]}})
    got = entry.read("x")
    assert got is not None
    assert got.meta == {"shapes": len(SHAPES), "nested": {"π": [1.5, None, "é"]}}
    assert list(got.arrays) == list(arrays)
    for name, array in arrays.items():
        assert got.arrays[name].dtype == np.dtype(dtype)
        assert got.arrays[name].shape == array.shape
        assert np.array_equal(got.arrays[name], array)


def test_no_arrays_at_all(entry: Entry) -> None:
    entry.write("x", {}, {"only": "meta"})
    got = entry.read("x")
    assert got is not None
    assert (got.arrays, got.meta) == ({}, {"only": "meta"})


def test_layout_of_the_source_does_not_matter(entry: Entry) -> None:
    a = np.arange(24.0).reshape(4, 6)
    entry.write(
        "x", {"t": a.T, "strided": a[::2, ::3], "frozen": np.broadcast_to(a[0], (3, 6))}, {}
    )
    got = entry.read("x")
    assert got is not None
    assert np.array_equal(got.arrays["t"], a.T)
    assert np.array_equal(got.arrays["strided"], a[::2, ::3])
    assert np.array_equal(got.arrays["frozen"], np.broadcast_to(a[0], (3, 6)))


def test_arrays_are_mapped_and_aligned_and_never_change_the_file(entry: Entry) -> None:
    entry.write("x", {"a": np.ones(3, np.int8), "b": np.ones((100, 3), np.float32)}, {})
    got = entry.read("x")
    assert got is not None
    for array in got.arrays.values():
        assert isinstance(mapping_under(array), mmap.mmap)
        assert array.ctypes.data % ALIGNMENT == 0
        array[0] = 2
    again = entry.read("x")
    assert again is not None
    assert all((array == 1).all() for array in again.arrays.values())


def test_mapped_arrays_outlive_replacement_and_removal(entry: Entry) -> None:
    entry.write("x", {"a": np.full(1000, 1.0)}, {})
    got = entry.read("x")
    entry.write("x", {"a": np.full(1000, 2.0)}, {})
    new = entry.read("x")
    entry.remove()
    assert got is not None
    assert new is not None
    assert (got.arrays["a"] == 1).all()
    assert (new.arrays["a"] == 2).all()
    assert entry.read("x") is None


def test_names_and_size(entry: Entry) -> None:
    assert entry.names() == []
    assert entry.size == 0
    entry.write("b", {"a": np.zeros(1000)}, {})
    entry.write("a.0", {}, {})
    assert entry.names() == ["a.0", "b"]
    assert 8000 < entry.size < 12000
    entry.remove()
    assert entry.names() == []


def test_same_content_gives_the_same_bytes(entry: Entry) -> None:
    first = small(entry).read_bytes()
    assert small(entry).read_bytes() == first


@pytest.mark.parametrize("damage", ["missing", "absent entry"])
def test_absent(entry: Entry, damage: str, caplog: pytest.LogCaptureFixture) -> None:
    if damage == "missing":
        small(entry)
    assert entry.read("other") is None
    assert not caplog.records


def test_every_truncation_is_found(entry: Entry, caplog: pytest.LogCaptureFixture) -> None:
    whole = small(entry).read_bytes()
    for length in range(len(whole)):
        path = entry.folder / "small.relight"
        path.write_bytes(whole[:length])
        caplog.clear()
        assert entry.read("small") is None, length
        assert not path.exists()
        assert str(path) in caplog.text
        assert caplog.records[0].levelno == logging.WARNING


def test_every_flipped_byte_is_found_or_harmless(
    entry: Entry, caplog: pytest.LogCaptureFixture
) -> None:
    path = small(entry)
    whole = bytearray(path.read_bytes())
    good = entry.read("small")
    assert good is not None
    harmless = []
    for position in range(len(whole)):
        broken = whole.copy()
        broken[position] ^= 1 << position % 8
        path.write_bytes(broken)
        got = entry.read("small")
        if got is not None:
            harmless.append(position)
            assert got.meta == good.meta
            assert all(np.array_equal(got.arrays[k], v) for k, v in good.arrays.items())
        else:
            assert not path.exists()
    # Only the zeros between the parts may differ unseen.
    assert all(whole[position] == 0 for position in harmless)
    assert len(harmless) < len(whole) - 16 - 10 - 12


def test_appended_bytes_are_found(entry: Entry) -> None:
    path = small(entry)
    path.write_bytes(path.read_bytes() + b"\0" * 64)
    assert entry.read("small") is None


def test_another_version_is_made_again(entry: Entry, caplog: pytest.LogCaptureFixture) -> None:
    path = small(entry)
    data = bytearray(path.read_bytes())
    struct.pack_into("<I", data, 8, VERSION + 1)
    path.write_bytes(data)
    assert entry.read("small") is None
    assert f"version {VERSION + 1}" in caplog.text
    small(entry)
    assert entry.read("small") is not None


@pytest.mark.parametrize(
    "bad",
    [
        np.array([object()]),
        np.array(["text"]),
        np.zeros(2, "i4,f4"),
        np.zeros(2, "M8[s]"),
    ],
)
def test_only_numbers_are_stored(entry: Entry, bad: np.ndarray) -> None:
    with pytest.raises(InputError, match="weights"):
        entry.write("x", {"weights": bad}, {})
    assert list(entry.folder.iterdir()) == []


@pytest.mark.parametrize("meta", [{"x": float("nan")}, {"x": object()}])
def test_meta_must_be_json(entry: Entry, meta: dict[str, object]) -> None:
    with pytest.raises(InputError, match="meta"):
        entry.write("x", {}, meta)
    assert list(entry.folder.iterdir()) == []


@pytest.mark.parametrize(
    "key",
    ["", ".", "..", "../x", "a/b", "/etc", "a\\b", ".hidden", "-x", "a\0b", "a b", "x" * 129, "ä"],
)
def test_keys_cannot_leave_the_store(tmp_path: Path, key: str) -> None:
    with pytest.raises(InputError, match="key"):
        Store(tmp_path).entry(key)
    with pytest.raises(InputError, match="name"):
        Store(tmp_path).entry("k").write(key, {}, {})
    with pytest.raises(InputError, match="name"):
        Store(tmp_path).entry("k").read(key)
    assert list(tmp_path.iterdir()) == []


def test_root_from_the_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path / "s"))
    assert Store().entry("k").folder == tmp_path / "s" / "k"
    monkeypatch.delenv("RELIGHT_STORE")
    assert Store().root.parts[-2:] == ("relight", "store")


def test_a_folder_that_cannot_be_written_is_named(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("in the way")
    with pytest.raises(StoreError, match="RELIGHT_STORE"):
        Store(tmp_path / "file").entry("k").write("x", {}, {})


WRITER = """
import sys
import numpy as np
from engine.store import Store
entry = Store(sys.argv[1]).entry("k")
print("ready", flush=True)
k = 0
while True:
    k += 1
    entry.write("x", {"a": np.full(1_000_000, k % 100, np.int32)}, {"k": k % 100})
"""


def killed(store: str, delay: float) -> None:
    """A process that saves without end, killed so many seconds after it began."""
    writer = subprocess.Popen([sys.executable, "-c", WRITER, store], stdout=subprocess.PIPE)
    with writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"ready\n"
        time.sleep(delay)
        os.kill(writer.pid, signal.SIGKILL)


def found_after_kills(tmp_path: Path, delays: Iterable[float]) -> int:
    """How often the file is there after a kill; it is whole then."""
    entry = Store(tmp_path).entry("k")
    found = 0
    for delay in delays:
        killed(str(tmp_path), delay)
        existed = (tmp_path / "k" / "x.relight").exists()
        got = entry.read("x")
        assert (got is not None) == existed, "a half file stood under the name"
        if got is not None:
            found += 1
            assert (got.arrays["a"] == got.meta["k"]).all()
        assert set(entry.names()) <= {"x"}
    return found


def test_a_killed_writer_leaves_no_half_file(tmp_path: Path) -> None:
    assert found_after_kills(tmp_path, (0.0, 0.02, 0.05, 0.09, 0.14)) > 0


@pytest.mark.sweep
def test_saving_killed_fifty_times(tmp_path: Path) -> None:
    delays = np.random.default_rng(8).uniform(0, 0.2, 50)
    assert found_after_kills(tmp_path, delays) > 25


@pytest.mark.sweep
def test_uploads_killed_fifty_times(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of an upload may stand under the name in a plain folder: it is not taken for a file."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    url = f"local://{tmp_path}/there"
    entry = Store(url).entry("k")
    found = 0
    for delay in np.random.default_rng(9).uniform(0, 0.2, 50):
        killed(url, delay)
        got = entry.read("x")
        if got is not None:
            found += 1
            assert (got.arrays["a"] == got.meta["k"]).all()
    assert found > 10


def test_what_killed_writers_left_goes_at_last(entry: Entry) -> None:
    small(entry)
    old, new = entry.folder / "small.1.part", entry.folder / "small.2.part"
    old.touch()
    new.touch()
    os.utime(old, (0, 0))
    small(entry)
    assert not old.exists()
    assert new.exists()


def test_concurrent_writers_and_readers(entry: Entry) -> None:
    problems: list[object] = []

    def write(value: int) -> None:
        for _ in range(15):
            entry.write("x", {"a": np.full(20_000, value)}, {"value": value})

    def read() -> None:
        for _ in range(60):
            got = entry.read("x")
            if got is None or not (got.arrays["a"] == got.meta["value"]).all():
                problems.append(got)

    write(0)
    threads = [threading.Thread(target=write, args=(k,)) for k in range(4)]
    threads += [threading.Thread(target=read) for _ in range(2)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert problems == []
    assert [path.name for path in entry.folder.iterdir()] == ["x.relight"]
