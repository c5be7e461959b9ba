"""What is sent comes in here: to a room of its own that is empty again afterwards.

At most MOST files come in at a time, and one of them is read at a time, since one may need much
memory; who would have to wait longer is told to come back.
"""

from __future__ import annotations

import asyncio
import contextlib
import hashlib
import shutil
import tempfile
import time
from collections.abc import AsyncIterator, Callable
from pathlib import Path
from typing import TypeVar

from starlette.requests import ClientDisconnect

from engine.errors import Cancelled, InputError
from server.problems import Busy

T = TypeVar("T")

MOST = 4
SECONDS = 600.0  # for a file to come in
PREFIX = "new-"  # of rooms
OLD_SECONDS = 24 * 3600.0


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


def sweep(folder: Path) -> None:
    """Remove rooms that a service left when it was killed."""
    for room in folder.glob(f"{PREFIX}*"):
        with contextlib.suppress(OSError):
            if time.time() - room.stat().st_mtime > OLD_SECONDS:
                shutil.rmtree(room, ignore_errors=True)
