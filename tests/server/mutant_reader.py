"""Read many damaged files in one process, each as the service's own reading processes do.

Lines of JSON come in: {"file", "room"}. A line goes out for each: {"accepted"}, {"refused"}, or
{"crashed"} with what was raised besides refusals, and {"touched"}: files outside of the room that
were written or that nobody should have read. What is accepted is shown too, as a small picture.
"""

from __future__ import annotations

import json
import sys
import tempfile
import traceback
from pathlib import Path
from typing import Any

import numpy as np

from engine.errors import InputError, RelightError
from engine.scene.camera import Camera
from engine.scene.edits import Edits
from server import acquire, decode, read_scene
from server.apart import limit
from server.shelf import Shelf
from server.stage import Stage

MAPS, MEASURED = (".exr", ".hdr"), (".brdf", ".csv", ".binary")
_touched: list[str] = []
_room = ""


def _watch(event: str, arguments: tuple[Any, ...]) -> None:
    """What the interpreter opens, see `sys.addaudithook`."""
    if event != "open" or not _room or not isinstance(arguments[0], str | bytes):
        return
    path, mode, flags = arguments
    place = str(Path(path.decode() if isinstance(path, bytes) else path).absolute())
    writes = (isinstance(mode, str) and any(c in mode for c in "wax+")) or (flags or 0) & 3
    if "secret" in place or (writes and not place.startswith(_room) and "nc" not in place):
        _touched.append(place)


def read(file: Path, room: Path) -> None:
    kind = file.suffix
    if kind in MAPS:
        decode.read(file, room / "made.exr")
        return
    if kind in MEASURED:
        acquire.read(file)
        return
    folder = room / "files"
    folder.mkdir()
    found = read_scene.read(file, folder)
    stage = Stage("mutant", str(folder / found["scene"]), "", Shelf(1e6))
    camera: Camera = stage.scene().camera.model_copy(update={"width": 12, "height": 9})
    image = stage.view(camera, 1).relight(Edits()).image
    if not np.isfinite(image).all():
        raise AssertionError("the picture is not finite")


def main() -> None:
    global _room
    limit()
    out, sys.stdout = sys.stdout, sys.stderr
    sys.addaudithook(_watch)
    print("ready", file=out, flush=True)
    for line in sys.stdin:
        asked = json.loads(line)
        _room, answer = asked["room"], {}
        tempfile.tempdir = _room
        _touched.clear()
        try:
            read(Path(asked["file"]), Path(asked["room"]))
            answer["accepted"] = True
        except InputError as error:
            answer["refused"] = str(error)
        except (RelightError, MemoryError) as error:
            answer["refused"] = str(error) or "memory"
        except Exception:
            answer["crashed"] = traceback.format_exc()[-1500:]
        _room = ""
        print(json.dumps({**answer, "touched": list(_touched)}), file=out, flush=True)


if __name__ == "__main__":
    main()
