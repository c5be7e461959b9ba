"""Entries of the store: folders of files that are whole or absent.

A file appears under its name by a rename, after its bytes have reached the disk, so a reader never
sees half of one, whoever is killed when. Of two writers of one name the last wins. What does not
pass its checksums is removed and reported as absent, so that the caller builds it again.
"""

from __future__ import annotations

import logging
import os
import re
import shutil
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import platformdirs
from numpy.typing import NDArray

from engine.errors import InputError, StoreError
from engine.store.format import Stored, load, save

log = logging.getLogger(__name__)

SUFFIX = ".relight"
_PART = ".part"
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,127}")
_ABANDONED_SECONDS = 24 * 3600


def _checked(kind: str, name: str) -> str:
    if not _NAME.fullmatch(name):
        raise InputError(
            f"{name!r} is not a {kind}: 1 to 128 letters, digits, '_', '-' or '.', "
            "the first no '-' or '.'",
            field=kind,
        )
    return name


@dataclass(frozen=True)
class Entry:
    """A folder of stored files; it need not exist until the first write."""

    folder: Path

    def write(self, name: str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]) -> None:
        """Store arrays and a JSON document under a name, in place of what was there.

        Raises InputError where they cannot be stored and StoreError where the disk refuses.
        """
        path = self._path(name)
        part: Path | None = None
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            self._sweep()
            with tempfile.NamedTemporaryFile(
                dir=self.folder, prefix=name + ".", suffix=_PART, delete=False
            ) as file:
                part = Path(file.name)
                save(file, arrays, meta)  # type: ignore[arg-type]
                file.flush()
                os.fsync(file.fileno())
            part.replace(path)
            part = None
            _sync_folder(self.folder)
        except OSError as error:
            raise StoreError(
                f"cannot write {path}: {error.strerror or error}; "
                "RELIGHT_STORE names another folder for the store"
            ) from error
        finally:
            if part is not None:
                part.unlink(missing_ok=True)

    def read(self, name: str) -> Stored | None:
        """What is stored under a name; None where nothing is, or nothing that is whole.

        The arrays are mapped, not read into memory, apart from one pass for the checksums. They
        are private to this process: what is written into them does not reach the file.
        """
        path = self._path(name)
        try:
            return load(path)
        except FileNotFoundError:
            return None
        except StoreError as error:
            log.warning("removed %s, it will be made again: %s", path, error)
            path.unlink(missing_ok=True)
            return None
        except OSError as error:
            raise StoreError(f"cannot read {path}: {error.strerror or error}") from error

    def names(self) -> list[str]:
        """Names of the files that are there, sorted."""
        return sorted(path.name.removesuffix(SUFFIX) for path in self.folder.glob("*" + SUFFIX))

    def remove(self) -> None:
        """Remove the entry with all its files; arrays that are still mapped stay valid."""
        shutil.rmtree(self.folder, ignore_errors=True)

    @property
    def size(self) -> int:
        """Bytes on disk."""
        return sum(path.stat().st_size for path in self.folder.glob("*" + SUFFIX))

    def _path(self, name: str) -> Path:
        return self.folder / (_checked("name", name) + SUFFIX)

    def _sweep(self) -> None:
        """Remove what writers left behind that were killed long ago."""
        for path in self.folder.glob("*" + _PART):
            try:
                if time.time() - path.stat().st_mtime > _ABANDONED_SECONDS:
                    path.unlink()
            except FileNotFoundError:
                pass  # its writer has just finished


class Store:
    """A folder of entries: RELIGHT_STORE, or the user's cache folder."""

    def __init__(self, root: Path | None = None) -> None:
        """Nothing is created before the first write."""
        asked = os.environ.get("RELIGHT_STORE")
        self.root = root or Path(asked or platformdirs.user_cache_path("relight") / "store")

    def entry(self, key: str) -> Entry:
        """The entry of a key, such as a content hash; raises InputError for what is no key."""
        return Entry(self.root / _checked("key", key))

    def remove(self) -> None:
        """Remove all entries; arrays that are still mapped stay valid."""
        shutil.rmtree(self.root, ignore_errors=True)


def _sync_folder(folder: Path) -> None:
    """Bring the rename itself to the disk, where the system can."""
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
