"""Find the files that a mesh file names: materials, buffers, textures.

Exporters write paths of the machine they ran on, with either slash, and files get moved next to the
mesh. So a name is looked for as written, then by its last part in the same folder, without regard
to case. Nothing outside the folder of the mesh is ever read.
"""

from __future__ import annotations

import contextlib
from io import UnsupportedOperation
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from engine.diagnosis import Diagnosis


class Companions:
    """The folder of a mesh file, as trimesh wants to see it (`trimesh.resolvers.Resolver`)."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.missing: dict[str, None] = {}

    def find(self, name: str) -> Path | None:
        """The file called `name`, or None, which is noted."""
        written = name.strip().replace("\\", "/")
        root = self.folder.resolve()
        # Options may stand before the file name in an MTL map.
        for candidate in (
            written,
            unquote(written),  # glTF has URIs
            written.rsplit("/", 1)[-1],
            written.split()[-1] if written else "",
        ):
            with contextlib.suppress(OSError, ValueError):  # what no file can be called
                path = (root / candidate).resolve()
                if candidate and path.is_relative_to(root) and path.is_file():
                    return path
        last = written.rsplit("/", 1)[-1].lower()
        for path in sorted(root.iterdir()):
            if path.name.lower() == last and path.is_file():
                return path
        self.missing[name] = None
        return None

    def get(self, name: str) -> bytes:
        """The content of the file called `name`."""
        path = self.find(name)
        if path is None:
            raise FileNotFoundError(name)
        return path.read_bytes()

    def __getitem__(self, name: str) -> bytes:
        return self.get(name)

    def __contains__(self, name: str) -> bool:
        return name in self.keys()

    def keys(self) -> list[str]:
        """The names of the files beside the mesh."""
        return sorted(path.name for path in self.folder.iterdir() if path.is_file())

    def write(self, name: str, data: Any) -> None:
        """Nothing is written: trimesh asks every resolver for it, but calls it in exports alone."""
        raise UnsupportedOperation(f"{name} is not written: the folder of a mesh is only read")

    def namespaced(self, namespace: str) -> Companions:
        """Nothing is read from another folder: trimesh asks for one for some other formats."""
        raise UnsupportedOperation(f"{namespace} is another folder")

    def diagnoses(self, file: str) -> list[Diagnosis]:
        """What was asked for and not found."""
        return [
            Diagnosis(
                "missing_file",
                f"{file} names {name}, which is not beside it: put it there to see it used",
            )
            for name in self.missing
        ]
