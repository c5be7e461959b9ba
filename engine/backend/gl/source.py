"""Shaders as text: each file once, however often it is included, and errors in their own terms."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from engine.errors import BackendError, NotFound
from engine.resources import resource

VERSION = 430
_INCLUDE = re.compile(r'\s*#include\s+"([^"]+)"\s*$')
# Mesa: 2:14(7): error; NVIDIA: 2(14) : error; others: ERROR: 2:14: ...
_PLACES = (
    re.compile(r"^(?P<file>\d+):(?P<line>\d+)\(\d+\)", re.M),
    re.compile(r"^(?P<file>\d+)\((?P<line>\d+)\)", re.M),
    re.compile(r"(?<=ERROR: )(?P<file>\d+):(?P<line>\d+)"),
    re.compile(r"(?<=WARNING: )(?P<file>\d+):(?P<line>\d+)"),
)


class Source(NamedTuple):
    """A whole shader. `files` are its parts by the numbers that GLSL's #line gives them."""

    text: str
    files: tuple[str, ...]

    def explain(self, log: str) -> str:
        """A compiler's log with file names in place of numbers."""
        for place in _PLACES:
            log = place.sub(self._place, log)
        return log

    def _place(self, found: re.Match[str]) -> str:
        number = int(found["file"])
        name = self.files[number] if number < len(self.files) else found["file"]
        return f"{name}:{found['line']}"


def load(
    name: str, defines: Mapping[str, int] | None = None, made: Mapping[str, str] | None = None
) -> Source:
    """The shader `name`, a path within `shaders/`, with everything that it includes.

    `defines` become macros. `made` holds files by their paths that are made by the engine rather
    than found. Raises BackendError for a file that is not there, saying who includes it.
    """
    lines = [f"#version {VERSION}"]
    lines += [f"#define {key} {value}" for key, value in (defines or {}).items()]
    files: list[str] = []
    _append(name, "", made or {}, lines, files)
    return Source("\n".join(lines) + "\n", tuple(files))


def _append(
    name: str, parent: str, made: Mapping[str, str], lines: list[str], files: list[str]
) -> None:
    text = made[name] if name in made else _read(name, parent)
    number = len(files)
    files.append(name)
    lines.append(f"#line 1 {number}")
    for row, line in enumerate(text.splitlines(), 1):
        include = _INCLUDE.match(line)
        if include is None:
            lines.append(line)
            continue
        if include[1] not in files:
            _append(include[1], f"{name}:{row}", made, lines, files)
        lines.append(f"#line {row + 1} {number}")


def _read(name: str, parent: str) -> str:
    try:
        return (resource("shaders") / name).read_text(encoding="utf-8")
    except (OSError, NotFound) as error:
        wanted = f", which {parent} includes" if parent else ""
        raise BackendError(f"the shader {name}{wanted} cannot be read: {error}") from None
