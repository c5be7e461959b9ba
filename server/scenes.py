"""Scenes that were sent to the service, this time or earlier.

As with maps nothing of what comes in is trusted. What was sent is read in a process of its own;
once it could be opened there, its files lie in a folder of the service that is called by the digest
of the bytes, and it is a scene like others. The oldest go when there are too many.
"""

from __future__ import annotations

import contextlib
import shutil
from collections.abc import AsyncIterator, Callable
from pathlib import Path

from pydantic import BaseModel, ValidationError

from engine.errors import InputError
from server.intake import SENT, Intake, digest_of, keep_note, notes, sweep
from server.maps import label_of
from server.measured import stem_of
from server.problems import Forbidden, UnknownKind
from server.read_scene import KINDS, read_scene
from server.stage import Stage
from server.stages import Stages

KEPT = 16
MAX_BYTES = 4 << 30  # of all that are kept


class Note(BaseModel):
    """What is kept beside the files: what people call the scene, and which of them it is."""

    label: str
    scene: str


class SentScenes:
    """The scenes that were sent; those of earlier times join the stages at once."""

    def __init__(
        self, folder: Path, stages: Stages, intake: Intake, left: Callable[[str], None]
    ) -> None:
        """Nothing is created before the first scene. `left` hears the names of those that go."""
        self._folder, self._stages, self._intake, self._left = folder, stages, intake, left
        sweep(folder)
        for note in reversed(notes(self._folder)):
            with contextlib.suppress(OSError, ValidationError):
                kept = Note.model_validate_json(note.read_text(encoding="utf-8"))
                self._join(note.stem, kept)

    async def add(self, chunks: AsyncIterator[bytes], file_name: str) -> Stage:
        """Keep the scene of a file, and have it among the stages.

        Raises UnknownKind for a file of another kind, InputError for one that cannot be used.
        """
        label = label_of(file_name)
        kind = Path(label).suffix.lower()
        if kind not in KINDS:
            raise UnknownKind(f"scenes come in files whose names end in {', '.join(KINDS)}")
        name = stem_of(label) + kind
        async with self._intake.received(chunks, self._folder, name) as (received, digest):
            try:
                note = await self._intake.read(lambda: self._take(received, digest, label))
            except InputError as error:
                raise InputError(error.message, field=error.field, file=label) from None
            stage = self._join(digest, note)
        await self._intake.read(self._let_go_of_the_oldest)
        return stage

    async def remove(self, name: str) -> None:
        """Forget a scene that was sent. Raises NotFound, and Forbidden for any other scene."""
        self._stages.get(name)
        digest = digest_of(name)
        if digest is None:
            raise Forbidden("only scenes that were sent can be removed")
        await self._intake.read(lambda: self._drop(self._folder / f"{digest}.json"))

    def _take(self, received: Path, digest: str, label: str) -> Note:
        place = self._folder / digest
        files = received.with_name("files")
        files.mkdir()
        # What was read once need not be again.
        known = self._folder / f"{digest}.json"
        with contextlib.suppress(OSError, ValidationError):
            note = Note.model_validate_json(known.read_text(encoding="utf-8"))
            if (place / note.scene).is_file():
                known.touch()
                return note
        note = Note(label=label, scene=str(read_scene(received, files)))
        shutil.rmtree(place, ignore_errors=True)
        files.rename(place)
        keep_note(note, received.parent, self._folder, digest)
        return note

    def _join(self, digest: str, note: Note) -> Stage:
        path = self._folder / digest / note.scene
        return self._stages.join(f"{SENT}{digest}", path, note.label)

    def _let_go_of_the_oldest(self) -> None:
        taken = 0
        for count, note in enumerate(notes(self._folder)):
            folder = note.with_suffix("")
            taken += sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())
            # The newest stays in any case.
            if count >= KEPT or (count and taken > MAX_BYTES):
                self._drop(note)

    def _drop(self, note: Path) -> None:
        name = f"{SENT}{note.stem}"
        self._stages.leave(name)
        self._left(name)
        note.unlink(missing_ok=True)
        shutil.rmtree(note.with_suffix(""), ignore_errors=True)
