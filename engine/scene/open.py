"""Open a scene: a built-in one by name, a description, or a mesh file."""

from __future__ import annotations

from pathlib import Path

from engine.errors import NotFound
from engine.scene.build import build
from engine.scene.builtin import BUILTIN
from engine.scene.description import SceneDescription
from engine.scene.scene import Scene


def scenes() -> dict[str, str]:
    """The built-in scenes: name and what it is, in a line."""
    return {name: summary for name, (summary, _) in BUILTIN.items()}


def open_scene(source: str | Path) -> Scene:
    """The scene that `source` names: a built-in scene, or a file."""
    if str(source) in BUILTIN:
        return build(SceneDescription.model_validate(BUILTIN[str(source)][1]()))
    raise NotFound(f"no scene {source}")
