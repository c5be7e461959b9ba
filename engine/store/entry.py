"""What an entry of the store is, wherever it lies: files that are whole or absent."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any, Protocol

from numpy.typing import NDArray

from engine.errors import InputError
from engine.store.format import Stored

SUFFIX, PART = ".relight", ".part"  # of what is whole, and of what is being written
_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,127}")


class Entry(Protocol):
    """Stored files of one key; there need not be any until the first write.

    What does not pass its checksums is removed and reported as absent, so that the caller builds
    it again.
    """

    def write(self, name: str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]) -> None:
        """Store arrays and a JSON document under a name, in place of what was there.

        Raises InputError where they cannot be stored and StoreError where the disk refuses.
        """

    def read(self, name: str) -> Stored | None:
        """What is stored under a name; None where nothing is, or nothing that is whole.

        The arrays are mapped, not read into memory, apart from one pass for the checksums. They
        are private to this process: what is written into them does not reach the file.
        """

    def names(self) -> list[str]:
        """Names of the files that are there, sorted."""

    def remove(self) -> None:
        """Remove the entry with all its files; arrays that are still mapped stay valid."""

    @property
    def size(self) -> int:
        """Bytes of its files."""


def checked(kind: str, name: str) -> str:
    """The name of a file, or the key of an entry; raises InputError for what is none."""
    if not _NAME.fullmatch(name):
        raise InputError(
            f"{name!r} is not a {kind}: 1 to 128 letters, digits, '_', '-' or '.', "
            "the first no '-' or '.'",
            field=kind,
        )
    return name
