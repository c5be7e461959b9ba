"""Measured materials by name: which may be asked for, and those that were sent to the service.

As with maps nothing of what comes in is trusted. What was sent is kept in the service's own folder
and called by the digest of its bytes; a file that the engine cannot read is not kept. Edits name
what is built in, in the scene's folder, of the scene itself, or was sent: nobody reads this disk by
them.
"""

from __future__ import annotations

import contextlib
import re
import shutil
from collections.abc import AsyncIterator
from pathlib import Path

from engine.brdf.measured import BUILT_IN, Measured
from engine.errors import EditError, InputError
from engine.scene.edits import Edits
from server.acquire import acquire
from server.intake import SENT, Intake, digest_of, keep_note, notes, sweep
from server.maps import label_of
from server.stage import MEASURED_FILES, Stage
from server.wire import MeasuredSent, MeasuredSummary

KEPT = 64


class Samples:
    """The measured materials that were sent, this time or earlier."""

    def __init__(self, folder: Path, intake: Intake) -> None:
        """Nothing is created before the first one."""
        self._folder, self._intake = folder, intake
        sweep(folder)

    def path(self, name: str) -> Path | None:
        """Where the file of a name lies; None where there is none."""
        digest = digest_of(name)
        files = list((self._folder / digest).glob("*")) if digest else []
        return files[0] if files else None

    def name_of(self, file: str) -> str:
        """What edits call a file; one that was not sent is called as it is."""
        folder = Path(file).parent
        return f"{SENT}{folder.name}" if folder.parent == self._folder else file

    def all(self) -> list[MeasuredSummary]:
        """The newest first."""
        found = []
        for note in notes(self._folder):
            with contextlib.suppress(OSError, ValueError):
                text = note.read_text(encoding="utf-8")
                found.append(MeasuredSummary.model_validate_json(text))
        return found

    async def add(self, chunks: AsyncIterator[bytes], file_name: str) -> MeasuredSent:
        """Keep a file of a measured material; raises InputError where it cannot be read."""
        label = label_of(file_name)
        kind = Path(label).suffix.lower()
        if kind not in MEASURED_FILES:
            kinds = ", ".join(sorted(MEASURED_FILES))
            raise InputError(
                f"measured materials come in files whose names end in {kinds}",
                field="name",
                file=label,
            )
        # Diagnoses call a material by its file.
        name = stem_of(label) + kind
        async with self._intake.received(chunks, self._folder, name) as (received, digest):
            try:
                return await self._intake.read(lambda: self._take(received, digest, label))
            except InputError as error:
                raise InputError(error.message, field=error.field, file=label) from None

    def _take(self, received: Path, digest: str, label: str) -> MeasuredSent:
        said = acquire(received)
        summary = MeasuredSummary(name=f"{SENT}{digest}", label=label, kind="upload")
        place = self._folder / digest
        if self.path(summary.name) is None:
            place.mkdir(exist_ok=True)
            received.replace(place / received.name)
        keep_note(summary, received.parent, self._folder, digest)
        for old in notes(self._folder)[KEPT:]:
            old.unlink(missing_ok=True)
            shutil.rmtree(old.with_suffix(""), ignore_errors=True)
        return MeasuredSent(material=summary, diagnoses=said)


def stem_of(label: str) -> str:
    """A name for a file on any disk."""
    return re.sub(r"[^A-Za-z0-9 _-]", "_", Path(label).stem)[:64].strip() or "sample"


def choices(stage: Stage, samples: Samples) -> list[MeasuredSummary]:
    """What may be asked for."""
    return [
        *(MeasuredSummary(name=name, label=name, kind="built_in") for name in BUILT_IN),
        *(MeasuredSummary(name=name, label=name, kind="beside") for name in stage.measured()),
        *samples.all(),
    ]


def file_of(file: str, stage: Stage, samples: Samples, field: str) -> str:
    """A file that somebody outside named, as the engine finds it from the scene's folder.

    Raises EditError for one that may not be asked for.
    """
    if file in BUILT_IN or stage.has_measured(file) or file in own(stage):
        return file
    path = samples.path(file)
    if path is None:
        raise EditError(
            f"no measured material {file[:80]!r} can be asked for here; there are "
            f"{', '.join(BUILT_IN)}, files in the scene's folder, and those that were sent",
            field=field,
        )
    return str(path)


def own(stage: Stage) -> set[str]:
    """Files that the scene itself names, wherever they lie."""
    return {m.file for m in stage.scene().materials if isinstance(m, Measured)}


def located(edits: Edits, stage: Stage, samples: Samples) -> Edits:
    """Edits from outside, with the measured materials that they name where they are."""
    changes = dict(edits.materials or {})
    for name, change in changes.items():
        file = change.get("file")
        if isinstance(file, str):
            found = file_of(file, stage, samples, f"materials.{name}.file")
            changes[name] = {**change, "file": found}
    return edits.model_copy(update={"materials": changes}) if changes else edits
