"""Read an environment map that somebody sent, in a process of its own.

Decoders of images are libraries for files that mean well. Whatever a file does to one ends this
process, by its own limits or by the service's patience, and not the service. What it leaves is a
latitude-longitude map that we have written ourselves.

`python -m server.decode IN OUT` writes a line of JSON: {"width", "height"} of the map or {"error"}.
"""

from __future__ import annotations

import contextlib
import json
import os
import subprocess
import sys
from pathlib import Path

from engine.errors import InputError

MAX_PIXELS = 1 << 24
SECONDS = 120.0
MEMORY = 8 << 30  # bytes of address space


def decode(source: Path, target: Path) -> tuple[int, int]:
    """Write the map of an .exr or .hdr file to `target`, an EXR file; its (width, height).

    Raises InputError where it cannot be used.
    """
    try:
        done = subprocess.run(
            [sys.executable, "-m", "server.decode", str(source), str(target)],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            env={**os.environ, "PYTHONPATH": os.pathsep.join([*filter(None, sys.path)])},
            text=True,
            timeout=SECONDS,
            check=False,
        )
    except subprocess.TimeoutExpired:
        raise InputError(f"it could not be read within {SECONDS:g} seconds") from None
    with contextlib.suppress(IndexError, json.JSONDecodeError, KeyError):
        report = json.loads(done.stdout.splitlines()[-1])
        if "error" in report:
            raise InputError(report["error"])
        return report["width"], report["height"]
    raise InputError("it is so damaged that reading it ended the reader")


def main() -> None:
    """The process's body."""
    if os.name == "posix":
        import resource

        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))

    from engine.errors import RelightError
    from engine.images import encode_exr, image_size
    from engine.light.maps import read_map

    source, target = Path(sys.argv[1]), Path(sys.argv[2])
    try:
        width, height = image_size(source)
        if not 0 < width * height <= MAX_PIXELS:
            raise InputError(
                f"it has {width} x {height} pixels, a map may have {MAX_PIXELS >> 20} million"
            )
        made = read_map(source)
        target.write_bytes(encode_exr(made))
        print(json.dumps({"width": made.shape[1], "height": made.shape[0]}))
    except InputError as error:
        print(json.dumps({"error": error.message}))
    except (RelightError, MemoryError) as error:
        print(json.dumps({"error": str(error) or "it needs more memory than there is"}))


if __name__ == "__main__":
    main()
