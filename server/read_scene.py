"""Try a scene that somebody sent; see `server.apart`.

`python -m server.read_scene FILE FOLDER` puts the files of the scene into the folder, which is
empty, opens it, and reports {"scene"}: which of them is the scene.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator
from pathlib import Path, PureWindowsPath
from typing import Any

from engine.errors import InputError
from server.apart import read_apart, report_from
from server.decode import MAX_PIXELS
from server.unpack import SHOWN, unpack

MESHES = (".gltf", ".glb", ".obj", ".ply", ".stl")
KINDS = (".zip", *MESHES)
DESCRIPTION = "scene.json"
MAX_TRIANGLES = 4_000_000
MAX_TEXELS = 1 << 26


def read_scene(source: Path, folder: Path) -> Path:
    """Unpack a file into the folder and open it; where its scene is, from the folder on.

    Raises InputError where it cannot be used.
    """
    report = read_apart("server.read_scene", source.parent, str(source), str(folder))
    return Path(report["scene"])


def read(source: Path, folder: Path) -> dict[str, Any]:
    """The process's body."""
    try:
        if source.suffix == ".zip":
            unpack(source, folder)
            scene = the_scene(folder)
        else:
            scene = source.rename(folder / source.name)
        if scene.suffix == ".json":
            _check_names(scene)
        _check_opened(scene)
    except InputError as error:
        # Nobody outside needs to know where this is.
        message = error.message.replace(f"{folder}/", "").replace(str(folder), "")
        file = Path(error.file).name if error.file else ""
        where = ", ".join(part for part in (file, error.field) if part and part != source.name)
        raise InputError(message, field=where) from None
    return {"scene": scene.relative_to(folder).as_posix()}


def the_scene(folder: Path) -> Path:
    """The scene among the files of a zip: scene.json, or the only mesh file there is."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    found = [path for path in files if path.name == DESCRIPTION]
    found = found or [path for path in files if path.suffix.lower() in MESHES]
    depth = min((len(path.parts) for path in found), default=0)
    highest = [path for path in found if len(path.parts) == depth]
    if not highest:
        raise InputError(f"there is neither a {DESCRIPTION} nor a mesh file in it")
    if len(highest) > 1:
        names = ", ".join(path.name[:40] for path in highest[:5])
        raise InputError(f"which is the scene, {names}? Say so in a {DESCRIPTION}, or leave one")
    return highest[0]


def _check_names(scene: Path) -> None:
    """No text of the description leads out of its folder, whatever it is for."""
    try:
        document = json.loads(scene.read_text(encoding="utf-8"))
    except (ValueError, RecursionError):
        return  # whoever opens it says so
    for field, text in _texts(document):
        # Which takes either slash, and a drive before it.
        path = PureWindowsPath(text)
        if path.root or ".." in path.parts:
            raise InputError(
                f"names {text[:SHOWN]}, which is not in its folder", field=field, file=scene.name
            )


def _texts(document: Any) -> Iterator[tuple[str, str]]:
    """All texts of a JSON document with the paths of their fields."""
    todo = [("", document)]
    while todo:
        field, value = todo.pop()
        if isinstance(value, str):
            yield field, value
        elif isinstance(value, dict | list):
            inner = value.items() if isinstance(value, dict) else enumerate(value)
            todo += [(f"{field}.{key}".lstrip("."), each) for key, each in inner]


def _check_opened(path: Path) -> None:
    """Opens the scene: it can be, and is not too much for a service."""
    from engine.scene.open import open_scene

    scene = open_scene(path)
    triangles, texels = len(scene.geometry.triangles), len(scene.material_table.texels)
    if triangles > MAX_TRIANGLES:
        raise InputError(f"it has {triangles:,} triangles; {MAX_TRIANGLES:,} are the most here")
    if texels > MAX_TEXELS:
        raise InputError(f"its textures have {texels:,} texels; {MAX_TEXELS:,} are the most here")
    if scene.environment is not None and scene.environment.radiance.size > 3 * MAX_PIXELS:
        raise InputError(f"its map has more than {MAX_PIXELS >> 20} million pixels")


if __name__ == "__main__":
    report_from(lambda: read(Path(sys.argv[1]), Path(sys.argv[2])))
