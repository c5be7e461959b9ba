"""OBJ files count vertices from the end where an index is negative: make such indices absolute.

trimesh takes -1 for the last vertex of the file; the format means the last one so far.
"""

from __future__ import annotations

import re

_RELATIVE = re.compile(rb"^f.*[ \t/]-\d", re.MULTILINE)


def absolute_indices(content: bytes) -> bytes:
    """The same file with every negative index of a face replaced by the positive one it means."""
    if not _RELATIVE.search(content):
        return content
    counts = {b"v": 0, b"vt": 0, b"vn": 0}
    lines = content.splitlines()
    for number, line in enumerate(lines):
        words = line.split()
        if not words:
            continue
        if words[0] in counts:
            counts[words[0]] += 1
        elif words[0] == b"f":
            lines[number] = b" ".join(
                [b"f"] + [_absolute(word, list(counts.values())) for word in words[1:]]
            )
    return b"\n".join(lines)


def _absolute(word: bytes, counts: list[int]) -> bytes:
    parts = word.split(b"/")
    for k, part in enumerate(parts[:3]):
        if part.startswith(b"-") and part[1:].isdigit():
            parts[k] = str(counts[k] + 1 + int(part)).encode()
    return b"/".join(parts)
