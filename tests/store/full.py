"""A disk that has room for so many bytes more."""

from __future__ import annotations

import errno
import os
import tempfile
from typing import Any

import pytest

from engine.store import folder


class Disk:
    """What the store's files may take, all together."""

    def __init__(self, room: int) -> None:
        self.room = room

    def install(self, monkeypatch: pytest.MonkeyPatch) -> None:
        """Let the store write here."""
        make = tempfile.NamedTemporaryFile
        monkeypatch.setattr(
            folder.tempfile, "NamedTemporaryFile", lambda **args: _File(make(**args), self)
        )


class _File:
    def __init__(self, file: Any, disk: Disk) -> None:
        self._file, self._disk, self.name = file, disk, file.name

    def __enter__(self) -> _File:
        return self

    def __exit__(self, *args: Any) -> None:
        self._file.close()

    def write(self, data: Any) -> int:
        self._disk.room -= len(data)
        if self._disk.room < 0:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return int(self._file.write(data))

    def __getattr__(self, name: str) -> Any:
        return getattr(self._file, name)
