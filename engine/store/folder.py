"""Entries that are folders of this machine.

A file appears under its name by a rename, after its bytes have reached the disk, so a reader never
sees half of one, whoever is killed when. Of two writers of one name the last wins.
"""

from __future__ import annotations

import contextlib
import logging
import os
import shutil
import tempfile
import time
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from numpy.typing import NDArray

from engine.errors import StoreError
from engine.store.entry import PART, SUFFIX, checked
from engine.store.format import Stored, load, save

log = logging.getLogger(__name__)

_ABANDONED_SECONDS = 24 * 3600


@dataclass(frozen=True)
class FolderEntry:
    """See `Entry`."""

    folder: Path

    def write(self, name: str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]) -> None:
        """See `Entry`."""
        path = self._path(name)
        part: Path | None = None
        try:
            self.folder.mkdir(parents=True, exist_ok=True)
            self._sweep()
            with tempfile.NamedTemporaryFile(
                dir=self.folder, prefix=name + ".", suffix=PART, delete=False
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
                f"cannot be written: {error.strerror or error}; "
                "RELIGHT_STORE names another folder for the store",
                file=str(path),
            ) from error
        finally:
            if part is not None:
                with contextlib.suppress(OSError):
                    part.unlink(missing_ok=True)

    def read(self, name: str) -> Stored | None:
        """See `Entry`."""
        path = self._path(name)
        try:
            return load(path)
        except FileNotFoundError:
            return None
        except StoreError as error:
            log.warning("%s will be made again: %s", path, error)
            with contextlib.suppress(OSError):  # what cannot be removed is written over, or not
                path.unlink(missing_ok=True)
            return None
        except OSError as error:
            message = f"cannot be read: {error.strerror or error}"
            raise StoreError(message, file=str(path)) from error

    def names(self) -> list[str]:
        """See `Entry`."""
        return sorted(path.name.removesuffix(SUFFIX) for path in self.folder.glob("*" + SUFFIX))

    def remove(self) -> None:
        """See `Entry`."""
        shutil.rmtree(self.folder, ignore_errors=True)

    @property
    def size(self) -> int:
        """See `Entry`."""
        return sum(path.stat().st_size for path in self.folder.glob("*" + SUFFIX))

    def _path(self, name: str) -> Path:
        return self.folder / (checked("name", name) + SUFFIX)

    def _sweep(self) -> None:
        """Remove what writers left behind that were killed long ago."""
        for path in self.folder.glob("*" + PART):
            try:
                if time.time() - path.stat().st_mtime > _ABANDONED_SECONDS:
                    path.unlink()
            except FileNotFoundError:
                pass  # its writer has just finished


def _sync_folder(folder: Path) -> None:
    """Bring the rename itself to the disk, where the system can."""
    if os.name == "posix":
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)
