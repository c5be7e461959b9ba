"""What is sent comes in here: to a room of its own that is empty again afterwards.

At most MOST files come in at a time, and one of them is read at a time, since one may need much
memory; who would have to wait longer is told to come back.

What is kept of each is called by the digest of its bytes; beside it lies a note, DIGEST.json, of
what people call it.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import re
import shutil
import tempfile
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel
from starlette.requests import ClientDisconnect

from engine.errors import Cancelled, InputError
from server.problems import Busy

T = TypeVar("T")

SENT = "upload:"  # begins the names of what was sent
MOST = 4
SECONDS = 600.0  # for a file to come in
PREFIX = "new-"  # of rooms
OLD_SECONDS = 24 * 3600.0
_NAME = re.compile(rf"{SENT}([0-9a-f]{{32}})")


class Intake:
    """The door of a service for all kinds of files; for its event loop alone."""

    def __init__(self) -> None:
        self._inside = 0
        self._reading = asyncio.Lock()

    @contextlib.asynccontextmanager
    async def received(
        self, chunks: AsyncIterator[bytes], folder: Path, name: str
    ) -> AsyncIterator[tuple[Path, str]]:
        """A file called `name` in a new room of the folder, and the digest of its bytes.

        The room goes in the end with whatever is in it. Raises Busy, Cancelled where the sender
        leaves, InputError where it takes too long.
        """
        if self._inside >= MOST:
            raise Busy(f"{MOST} files are coming in already")
        self._inside += 1
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(dir=folder, prefix=PREFIX) as room:
                path = Path(room) / name
                yield path, await _written(chunks, path)
        finally:
            self._inside -= 1

    async def read(self, work: Callable[[], T]) -> T:
        """What `work` returns, done in a thread, one at a time."""
        async with self._reading:
            return await asyncio.to_thread(work)


async def _written(chunks: AsyncIterator[bytes], path: Path) -> str:
    digest = hashlib.blake2b(digest_size=16)
    try:
        async with asyncio.timeout(SECONDS):
            with path.open("wb") as file:
                async for chunk in chunks:
                    digest.update(chunk)
                    file.write(chunk)
    except TimeoutError:
        raise InputError(f"it was not all sent within {SECONDS:g} seconds") from None
    except ClientDisconnect:
        raise Cancelled("the sender has left") from None
    return digest.hexdigest()


def digest_of(name: str) -> str | None:
    """The digest in the name of something that was sent; None for another name."""
    found = _NAME.fullmatch(name)
    return found[1] if found else None


def keep_note(note: BaseModel, room: Path, folder: Path, digest: str) -> None:
    """Write the note of what is kept; it is there whole or not at all."""
    written = room / "note"
    written.write_text(note.model_dump_json(), encoding="utf-8")
    written.replace(folder / f"{digest}.json")


def notes(folder: Path) -> list[Path]:
    """Of all that is kept there, the newest first."""
    return sorted(folder.glob("*.json"), key=lambda path: path.stat().st_mtime, reverse=True)


def sweep(folder: Path) -> None:
    """Remove rooms that a service left when it was killed."""
    for room in folder.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):
            if time.time() - room.stat().st_mtime > OLD_SECONDS:
                shutil.rmtree(room, ignore_errors=True)
