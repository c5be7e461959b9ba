"""Entries on any file system that fsspec knows, such as an object store: `s3://bucket/folder`.

A file is uploaded under its name when its bytes are complete; object stores show it whole or not at
all, and what another kind of store shows of half an upload does not pass its checksums. Files are
read by way of copies in a folder of this machine, which are mapped. A copy is called after what the
store says of the file (size, time, tag), so one of an older file is not taken for it.
"""

from __future__ import annotations

import contextlib
import logging
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path, PurePosixPath
from typing import Any

from numpy.typing import NDArray

from engine.errors import InputError, RelightError, StoreError
from engine.store.entry import PART, SUFFIX, checked
from engine.store.format import Stored, load, save

log = logging.getLogger(__name__)


def opened(url: str) -> tuple[Any, str]:
    """(fsspec's file system, folder in it) of a URL.

    Raises RelightError where a package is missing and StoreError for what is no such URL.
    """
    try:
        import fsspec
    except ModuleNotFoundError:
        raise RelightError(
            "a store that is no folder of this machine needs fsspec; "
            "please run: pip install 'relight[cluster]'"
        ) from None
    try:
        # Others write to the store too: what was listed a while ago says nothing.
        files, folder = fsspec.url_to_fs(url, use_listings_cache=False)
    except (ImportError, ValueError) as error:  # fsspec says which package that kind of URL needs
        raise StoreError(f"RELIGHT_STORE cannot be opened: {error}") from None
    return files, folder


@dataclass(frozen=True)
class RemoteEntry:
    """See `Entry`.

    files   fsspec's file system
    folder  in it
    copies  folder of this machine, for what was read
    """

    files: Any
    folder: str
    copies: Path

    def write(self, name: str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]) -> None:
        """See `Entry`."""
        path = self._path(name)
        with _saying("written", path), self._room(name) as part:
            with part.open("wb") as file:
                save(file, arrays, meta)
            self.files.makedirs(self.folder, exist_ok=True)
            self.files.put_file(str(part), path)

    def read(self, name: str) -> Stored | None:
        """See `Entry`."""
        path = self._path(name)
        with _saying("read", path):
            try:
                copy = self._copy(name, path)
            except FileNotFoundError:
                return None
            try:
                return load(copy)
            except FileNotFoundError:
                pass
            except StoreError:
                copy.unlink(missing_ok=True)  # it may be the copy alone that is damaged
            return self._download(name, path, copy)

    def names(self) -> list[str]:
        """See `Entry`."""
        return sorted(file.name.removesuffix(SUFFIX) for file in self._files())

    def remove(self) -> None:
        """See `Entry`."""
        with _saying("removed", self.folder), contextlib.suppress(FileNotFoundError):
            self.files.rm(self.folder, recursive=True)
        shutil.rmtree(self.copies, ignore_errors=True)

    @property
    def size(self) -> int:
        """See `Entry`."""
        return sum(self._files().values())

    def _files(self) -> dict[PurePosixPath, int]:
        """Files and their bytes."""
        with _saying("listed", self.folder):
            try:
                listed = self.files.ls(self.folder, detail=True)
            except FileNotFoundError:
                return {}
        files = {PurePosixPath(each["name"]): int(each["size"]) for each in listed}
        return {file: size for file, size in files.items() if file.suffix == SUFFIX}

    def _path(self, name: str) -> str:
        return f"{self.folder}/{checked('name', name)}{SUFFIX}"

    def _copy(self, name: str, path: str) -> Path:
        """Where the copy of the file as it is now lies; FileNotFoundError where there is none."""
        return self.copies / name / (self.files.ukey(path)[:32] + SUFFIX)

    def _download(self, name: str, path: str, copy: Path) -> Stored | None:
        with self._room(name) as part:
            try:
                self.files.get_file(path, str(part))
                found = load(part)
            except FileNotFoundError:
                return None
            except StoreError as error:
                log.warning("%s will be made again: %s", path, error)
                with contextlib.suppress(OSError):  # what cannot be removed is written over
                    self.files.rm_file(path)
                return None
            copy.parent.mkdir(exist_ok=True)
            part.replace(copy)  # it stays mapped
        for other in copy.parent.iterdir():
            if other != copy:
                other.unlink(missing_ok=True)
        return found

    @contextlib.contextmanager
    def _room(self, name: str) -> Iterator[Path]:
        """Where to write a file of this machine, which goes again."""
        self.copies.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=self.copies, suffix=PART) as folder:
            yield Path(folder) / name


@contextlib.contextmanager
def _saying(what: str, path: str) -> Iterator[None]:
    """Whatever a kind of store raises becomes a StoreError that says what could not be done."""
    try:
        yield
    except (StoreError, InputError):
        raise
    except Exception as error:
        raise StoreError(
            f"cannot be {what}: {error or type(error).__name__}; "
            "RELIGHT_STORE names another place for the store",
            file=path,
        ) from error
