"""Read an environment map that somebody sent; see `server.apart`.

What it leaves is a latitude-longitude map that we have written ourselves.

`python -m server.decode IN OUT` reports {"width", "height"} of the map.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from engine.errors import InputError
from server.apart import read_apart, report_from

MAX_PIXELS = 1 << 24


def decode(source: Path, target: Path) -> tuple[int, int]:
    """Write the map of an .exr or .hdr file to `target`, an EXR file; its (width, height).

    Raises InputError where it cannot be used.
    """
    report = read_apart("server.decode", source.parent, str(source), str(target))
    return report["width"], report["height"]


def read(source: Path, target: Path) -> dict[str, Any]:
    """The process's body."""
    from engine.images import encode_exr, image_size
    from engine.light.maps import read_map

    width, height = image_size(source)
    if not 0 < width * height <= MAX_PIXELS:
        raise InputError(
            f"it has {width} x {height} pixels, a map may have {MAX_PIXELS >> 20} million"
        )
    made = read_map(source)
    target.write_bytes(encode_exr(made))
    return {"width": made.shape[1], "height": made.shape[0]}


if __name__ == "__main__":
    report_from(lambda: read(Path(sys.argv[1]), Path(sys.argv[2])))
