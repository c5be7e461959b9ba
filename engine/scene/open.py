"""Open a scene: a built-in one by name, a description, or a mesh file."""

from __future__ import annotations

import json
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from engine.errors import NotFound, SceneError
from engine.scene.build import build, build_from_mesh
from engine.scene.builtin import BUILTIN
from engine.scene.description import SceneDescription
from engine.scene.explain import closest, explain
from engine.scene.mesh_files import FORMATS
from engine.scene.scene import Scene

MAX_DESCRIPTION = 64 * 2**20


def scenes() -> dict[str, str]:
    """The built-in scenes: name and what it is, in a line."""
    return {name: summary for name, (summary, _) in BUILTIN.items()}


@cache
def schema() -> dict[str, Any]:
    """The published JSON schema of scene descriptions."""
    return SceneDescription.model_json_schema()


def open_scene(source: str | Path) -> Scene:
    """The scene that `source` names: a built-in scene, a description in JSON, or a mesh file.

    Raises NotFound where there is neither such a file nor such a built-in scene, SceneError, with
    the field and the file, where the scene cannot be used.
    """
    if str(source) in BUILTIN:
        return build(describe(BUILTIN[str(source)][1]()), Path())
    path = Path(source)
    if not path.exists():
        raise NotFound(
            f"there is no file {str(source)!r} and no built-in scene of that name; "
            f"{closest(str(source), BUILTIN)}"
        )
    kind = path.suffix.lower().lstrip(".")
    if kind in FORMATS and path.is_file():
        return build_from_mesh(path)
    if kind != "json" or not path.is_file():
        raise SceneError(
            f"a scene is a file of type json, {', '.join(FORMATS)}, or one of {', '.join(BUILTIN)}",
            file=path.name,
        )
    try:
        return build(describe(_document(path)), path.parent)
    except SceneError as error:
        raise SceneError(error.message, field=error.field, file=error.file or path.name) from None


def describe(document: Any) -> SceneDescription:
    """A description from what JSON holds. Raises SceneError, which names the field."""
    try:
        return SceneDescription.model_validate(document)
    except ValidationError as error:
        field, sentence = explain(error, document, schema())
        raise SceneError(sentence, field=field) from None


def _document(path: Path) -> Any:
    try:
        if path.stat().st_size > MAX_DESCRIPTION:
            raise SceneError(f"a description may have at most {MAX_DESCRIPTION >> 20} MB")
        return json.loads(path.read_text(encoding="utf-8"))
    except json.JSONDecodeError as error:
        raise SceneError(
            f"is not JSON: {error.msg} in line {error.lineno}, column {error.colno}"
        ) from None
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}") from None
    except (ValueError, RecursionError) as error:
        raise SceneError(f"cannot be read: {error}") from None
