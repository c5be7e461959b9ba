"""All scenes of the service, by their names in URLs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from engine.errors import NotFound
from engine.scene.open import scenes
from server.intake import SENT
from server.shelf import Shelf
from server.stage import Direct, Stage

MEMORY = 4e9  # bytes of products and of the pictures that they are seen in
KEPT_DIRECT = 1 << 22  # pixels of views in direct light, of all scenes together


@dataclass(frozen=True)
class Stages:
    """All scenes by their name in URLs; the first is the default."""

    stages: dict[str, Stage]
    shelf: Shelf
    direct: Direct

    @property
    def default(self) -> Stage:
        """The scene that the page opens."""
        return next(iter(self.stages.values()))

    def get(self, name: str) -> Stage:
        """Raises NotFound."""
        try:
            return self.stages[name]
        except KeyError:
            known = ", ".join(name for name in self.stages if not name.startswith(SENT))
            raise NotFound(f"there is no scene {name!r:.80}; there are {known}") from None

    def join(self, name: str, path: Path, description: str) -> Stage:
        """The stage of a scene that was sent; a new one where it is not here."""
        return self.stages.setdefault(
            name, Stage(name, str(path.resolve()), description, self.shelf, self.direct)
        )

    def leave(self, name: str) -> None:
        """A scene that was sent goes; who looks at it may go on."""
        self.stages.pop(name, None)


def stages(sources: Sequence[str], memory: float = MEMORY) -> Stages:
    """The sources in their order, then the built-in scenes that are not among them.

    In so many bytes of memory their products are kept. A source is the name of a built-in scene or
    a file. NotFound where it is neither.
    """
    builtin = dict(scenes())
    found: dict[str, Stage] = {}
    shelf = Shelf(memory)
    direct = Direct(KEPT_DIRECT, lambda preview: len(preview.view.buffer.centre))
    for source in sources:
        if source in builtin:
            found[source] = Stage(source, source, builtin[source], shelf, direct)
            continue
        path = Path(source)
        if not path.exists():
            raise NotFound(
                f"there is no file {source!r} and no built-in scene of that name; "
                f"there are {', '.join(builtin)}"
            )
        name = unique(slug(path), {*found, *builtin})
        found[name] = Stage(name, str(path.resolve()), path.name, shelf, direct)
    for source, description in builtin.items():
        if source not in found:
            found[source] = Stage(source, source, description, shelf, direct)
    return Stages(found, shelf, direct)


def slug(path: Path) -> str:
    """Lower-case letters, digits and hyphens from a file name; `scene.json` takes its folder's."""
    stem = path.resolve().parent.name if path.stem == "scene" else path.stem
    return re.sub(r"[^a-z0-9]+", "-", stem.lower()).strip("-") or "scene"


def unique(name: str, taken: set[str]) -> str:
    """The name, with a number behind it where it is taken."""
    candidate, number = name, 2
    while candidate in taken:
        candidate, number = f"{name}-{number}", number + 1
    return candidate
