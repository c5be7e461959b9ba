"""Environment maps by name: which may be asked for, and those that were sent to the service.

These are kept in its own folder. Nothing of what comes in is trusted. A map's name is the digest of
its bytes, its file is one that `server.decode` wrote, and no path leaves the service. The oldest go
when there are too many.
"""

from __future__ import annotations

import contextlib
from collections.abc import AsyncIterator
from pathlib import Path, PurePosixPath, PureWindowsPath

from engine.errors import EditError, InputError
from engine.light.maps import BUILT_IN
from engine.scene.edits import Edits
from server.decode import decode
from server.intake import SENT, Intake, digest_of, keep_note, notes, sweep
from server.stage import Stage
from server.wire import MapSummary

KEPT = 32
LABEL = 80  # characters
SIGNATURES = {b"\x76\x2f\x31\x01": ".exr", b"#?": ".hdr"}


class Uploads:
    """The maps that were sent, this time or earlier."""

    def __init__(self, folder: Path, intake: Intake) -> None:
        """Nothing is created before the first map."""
        self._folder, self._intake = folder, intake
        sweep(folder)

    def path(self, name: str) -> Path | None:
        """Where the map of a name lies; None where there is none."""
        digest = digest_of(name)
        path = self._folder / f"{digest}.exr" if digest else None
        return path if path is not None and path.is_file() else None

    def all(self) -> list[MapSummary]:
        """The newest first."""
        found = []
        for path in notes(self._folder):
            with contextlib.suppress(OSError, ValueError):
                found.append(MapSummary.model_validate_json(path.read_text(encoding="utf-8")))
        return found

    async def add(self, chunks: AsyncIterator[bytes], file_name: str) -> MapSummary:
        """Keep the map of an OpenEXR or Radiance HDR file; raises InputError for any other."""
        label = label_of(file_name)
        async with self._intake.received(chunks, self._folder, "map") as (received, digest):
            try:
                return await self._intake.read(lambda: self._take(received, digest, label))
            except InputError as error:
                raise InputError(error.message, field="map", file=label) from None

    def _take(self, received: Path, digest: str, label: str) -> MapSummary:
        with received.open("rb") as file:
            start = file.read(4)
        kind = next((kind for s, kind in SIGNATURES.items() if start.startswith(s)), None)
        if kind is None:
            raise InputError("it is neither an OpenEXR file nor a Radiance HDR file")
        source = received.rename(received.with_suffix(kind))
        made = received.with_name("made.exr")
        width, height = decode(source, made)
        summary = MapSummary(name=f"{SENT}{digest}", label=label, width=width, height=height)
        made.replace(self._folder / f"{digest}.exr")
        keep_note(summary, received.parent, self._folder, digest)
        for old in notes(self._folder)[KEPT:]:
            old.unlink(missing_ok=True)
            old.with_suffix(".exr").unlink(missing_ok=True)
        return summary


def located(edits: Edits, stage: Stage, uploads: Uploads) -> Edits:
    """Edits from outside, with the map that they name where it is.

    They name what is built in, in the scene's folder, or was sent: nobody reads this disk by them.
    Raises EditError for anything else.
    """
    change = edits.environment or {}
    name = change.get("map")
    if not isinstance(name, str) or name in BUILT_IN or stage.has_map(name):
        return edits
    path = uploads.path(name)
    if path is None:
        raise EditError(
            f"no map {name!r} can be asked for here; there are {', '.join(BUILT_IN)}, files in the "
            "scene's folder, maps that were sent, a radiance [r, g, b], or a sky",
            field="environment.map",
        )
    return edits.model_copy(update={"environment": {**change, "map": str(path)}})


def label_of(file_name: str) -> str:
    """What to call a map of a file's name: no folder, nothing that cannot be shown."""
    name = PurePosixPath(PureWindowsPath(file_name).name).name
    shown = "".join(c for c in name if c.isprintable())[:LABEL].strip()
    return shown or "map"
