"""Shaders as text: each file once, however often it is included, and errors in their own terms.

Drivers disagree on #line, and some forget the number of the file, so the text has none: line
numbers of the whole are translated into those of the files.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import NamedTuple

from engine.errors import BackendError, NotFound
from engine.resources import resource

VERSION = 430
_INCLUDE = re.compile(r'\s*#include\s+"([^"]+)"\s*$')
# Mesa: 0:14(7): error; NVIDIA: 0(14) : error; others: ERROR: 0:14: ...
_PLACE = re.compile(
    r"^(?P<before>(?:ERROR: |WARNING: )?)\d+(?::(?P<a>\d+)(?:\(\d+\))?|\((?P<b>\d+)\))", re.M
)


class Source(NamedTuple):
    """A whole shader, and for every line of it the file and line that it is from."""

    text: str
    places: tuple[str, ...]

    def explain(self, log: str) -> str:
        """A compiler's log with files and their lines in place of lines of the whole."""
        return _PLACE.sub(self._place, log)

    def _place(self, found: re.Match[str]) -> str:
        line = int(found["a"] or found["b"])
        known = 1 <= line <= len(self.places)
        return found["before"] + (self.places[line - 1] if known else found[0])


def load(
    name: str, defines: Mapping[str, int] | None = None, made: Mapping[str, str] | None = None
) -> Source:
    """The shader `name`, a path within `shaders/`, with everything that it includes.

    `defines` become macros. `made` holds files by their paths that are made by the engine rather
    than found. Raises BackendError for a file that is not there, saying who includes it.
    """
    lines = [f"#version {VERSION}"]
    lines += [f"#define {key} {value}" for key, value in (defines or {}).items()]
    places = ["the first lines"] * len(lines)
    _append(name, "", made or {}, lines, places, set())
    return Source("\n".join(lines) + "\n", tuple(places))


def _append(
    name: str,
    parent: str,
    made: Mapping[str, str],
    lines: list[str],
    places: list[str],
    done: set[str],
) -> None:
    done.add(name)
    text = made[name] if name in made else _read(name, parent)
    for row, line in enumerate(text.splitlines(), 1):
        place = f"{name}:{row}"
        include = _INCLUDE.match(line)
        if include is None:
            lines.append(line)
            places.append(place)
        elif include[1] not in done:
            _append(include[1], place, made, lines, places, done)


def _read(name: str, parent: str) -> str:
    try:
        return (resource("shaders") / name).read_text(encoding="utf-8")
    except (OSError, NotFound) as error:
        wanted = f", which {parent} includes" if parent else ""
        raise BackendError(f"the shader {name}{wanted} cannot be read: {error}") from None
