"""What the words of the command line mean: scenes, methods, settings, edits."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.published import PUBLISHED
from engine.errors import InputError, NotFound, RelightError
from engine.measure.settings import parse_assignments, parse_value, settings_from
from engine.methods import METHODS
from engine.scene.edits import Edits, edited_camera, problems
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.terminal import warn

DEFAULT_METHOD = "direct_to_indirect"


def sized_scene(source: str, size: str | None) -> Scene:
    """The scene of a name or file, with WxH pixels in place of its own; warnings are printed."""
    scene = open_scene(source)
    warn(scene.diagnoses)
    if size is None:
        return scene
    width, height = picture_size(size)
    return scene.with_camera(edited_camera(scene.camera, {"width": width, "height": height}))


def picture_size(size: str) -> tuple[int, int]:
    """(640, 480) of 640x480."""
    numbers = re.fullmatch(r"(\d+)x(\d+)", size)
    if numbers is None:
        raise InputError(f"{size!r} is not of the form 640x480", field="size")
    width, height = map(int, numbers.groups())
    return width, height


def materials_of(source: str | None) -> dict[str, Material]:
    """The glossy materials of a scene by name, or without one those of the paper on them."""
    if source is None:
        return PUBLISHED
    scene = open_scene(source)
    every = zip(scene.material_names, scene.materials, strict=True)
    glossy = {name: material for name, material in every if not isinstance(material, Diffuse)}
    if not glossy:
        raise InputError(f"all materials of {source!r} are diffuse: one term is exact for them")
    return glossy


def known_method(method: str) -> str:
    """The name, if it is that of a method; NotFound else."""
    if method not in METHODS:
        raise NotFound(f"there is no method {method!r}; there are {', '.join(METHODS)}")
    return method


def settings_of(method: str, assignments: list[str] | None) -> Any:
    """A method's settings with KEY=VALUE assignments in them."""
    return settings_from(
        METHODS[known_method(method)].settings, parse_assignments(assignments or ())
    )


def words(text: str) -> list[str]:
    """["lights", "materials"] from `lights,materials`."""
    return [part.strip() for part in text.split(",") if part.strip()]


def knobs(sweep: list[str] | None) -> dict[str, list[Any]] | None:
    """{"coefficients": [25, 100]} from `coefficients=25,100`."""
    if sweep is None:
        return None
    texts = parse_assignments(sweep, parse=str)
    return {name: [parse_value(part) for part in text.split(",")] for name, text in texts.items()}


def read_edits(path: Path | None) -> Edits:
    """Edits from a file of JSON, or none; InputError names file and field."""
    if path is None:
        return Edits()
    try:
        return Edits.model_validate_json(path.read_bytes())
    except OSError as error:
        raise InputError(f"cannot be read: {error.strerror}", file=str(path)) from None
    except ValidationError as error:
        problem = problems(error, "")
        raise InputError(problem.message, field=problem.field.strip("."), file=str(path)) from None


@contextlib.contextmanager
def needs_extra(extra: str) -> Iterator[None]:
    """Tell what to install where the body misses a package of an optional extra."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise RelightError(
            f"this needs {error.name}; please run: pip install 'relight[{extra}]'"
        ) from None
