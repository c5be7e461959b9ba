"""What the headers of PLY and STL files promise, held against the bytes that follow.

A reader that believes a count makes room for it, so one that the file cannot hold is refused first.
"""

from __future__ import annotations

import re
import struct
from collections.abc import Iterator

from engine.errors import SceneError

_PLY_BYTES = {
    b"char": 1, b"uchar": 1, b"int8": 1, b"uint8": 1,
    b"short": 2, b"ushort": 2, b"int16": 2, b"uint16": 2,
    b"int": 4, b"uint": 4, b"int32": 4, b"uint32": 4, b"float": 4, b"float32": 4,
    b"double": 8, b"float64": 8,
}  # fmt: skip
_PLY_END = re.compile(rb"^end_header[ \t]*\r?\n", re.MULTILINE)
_PLY_HEADER = 1 << 16  # bytes that a header never fills
_STL_HEADER, _STL_TRIANGLE = 84, 50


def check_ply(content: bytes, file: str) -> None:
    """Raises SceneError where a PLY file counts more than it can hold."""
    end = _PLY_END.search(content[:_PLY_HEADER])
    if end is None:
        raise SceneError("cannot be read as PLY: its header does not end", file=file)
    text = b"format ascii" in content[: end.start()]
    left = len(content) - end.end()
    for name, count, least in _elements(content[: end.start()], text, file):
        if count * least > left + text:  # the last line of a text may do without its end
            raise SceneError(
                f"its header promises {count:,} of {name!r}, more than the {left:,} bytes "
                "after it can hold",
                file=file,
            )


def _elements(header: bytes, text: bool, file: str) -> Iterator[tuple[str, int, int]]:
    """(name, count, bytes that one takes at least) of what a header promises."""
    name, count, least = "", 0, 0
    for line in header.splitlines():
        words = line.split()
        if words[:1] == [b"element"] and len(words) == 3:
            yield name, count, least
            if not words[2].isdigit() or len(words[2]) > 18:
                said = words[2][:20].decode("latin-1")
                raise SceneError(f"its header counts {said!r}, which is no number", file=file)
            name, count, least = words[1].decode("latin-1")[:40], int(words[2]), 0
        elif words[:1] == [b"property"] and len(words) > 2:
            # Of a list its length; of a text a digit and what parts it from the next.
            kind = words[2] if words[1] == b"list" else words[1]
            least += 2 if text else _PLY_BYTES.get(kind, 1)
    yield name, count, least


def check_stl(content: bytes, file: str) -> None:
    """Raises SceneError where a binary STL file is not as long as it says."""
    if len(content) < _STL_HEADER or content.lstrip()[:5].lower() == b"solid":
        return  # a text, or too short for anything
    count = struct.unpack_from("<I", content, _STL_HEADER - 4)[0]
    long = _STL_HEADER + count * _STL_TRIANGLE
    if long != len(content):
        raise SceneError(
            f"its header counts {count:,} triangles, which take {long:,} bytes, "
            f"but the file has {len(content):,}",
            file=file,
        )
