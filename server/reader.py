"""One thread that reads measured materials and draws their thumbnails.

To read and encode a file takes seconds. The engine keeps what it has encoded, so what has been
here once costs the render thread nothing: a picture with a new material goes through here first,
while others are drawn.
"""

from __future__ import annotations

import asyncio
import hashlib
import json
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, NamedTuple

from engine.brdf.base import Material
from engine.brdf.table import INDEX
from engine.brdf.thumbnail import thumbnail
from engine.errors import EditError, SceneError
from engine.images import encode
from server.precompute import Materials
from server.shelf import Recent
from server.stage import Stage

KEPT_THUMBNAILS = 512
KEPT_FILES = 32  # fewer than the engine keeps


class Picture(NamedTuple):
    """A PNG file, and a tag that tells it from others."""

    tag: str
    data: bytes


class Reader:
    """The thread and what it has done."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, "relight-read")
        self._thumbnails: Recent[str, Picture] = Recent(KEPT_THUMBNAILS)
        self._read: Recent[str, bool] = Recent(KEPT_FILES)

    async def read(self, stage: Stage, materials: Materials | None) -> None:
        """Have the files of edits of materials read, if they are new. Raises EditError."""
        new = {}
        for name, change in (materials or {}).items():
            if "file" in change and not self._read.get(_name(stage, change["file"])):
                new[name] = change
        if not new:
            return
        await asyncio.get_running_loop().run_in_executor(self._pool, stage.with_materials, new)
        for change in new.values():
            self._read.keep(_name(stage, change["file"]), True)

    async def thumbnail(self, stage: Stage, material: Material) -> Picture:
        """The material as a ball; EditError where its file cannot be read."""
        return await asyncio.get_running_loop().run_in_executor(
            self._pool, self._draw, stage, material
        )

    def _draw(self, stage: Stage, material: Material) -> Picture:
        try:
            material = material.located(Path(stage.scene().folder))
        except SceneError as error:
            place = f"material.{error.field}"
            raise EditError(error.message, field=place, file=error.file) from None
        # A row has the digest of the code in it, so that a file that has changed is another.
        digest = hashlib.blake2b(material.row().tobytes(), digest_size=16)
        digest.update(bytes([INDEX[type(material)]]))
        tag = digest.hexdigest()
        known = self._thumbnails.use(tag)
        if known is None:
            known = Picture(tag, encode(thumbnail(material), "png"))
            self._thumbnails.keep(tag, known)
        return known

    def close(self) -> None:
        """Finish what is at hand, drop the rest."""
        self._pool.shutdown(wait=True, cancel_futures=True)


def _name(stage: Stage, file: Any) -> str:
    return json.dumps([stage.name, file])
