"""Edits: the scene's own vocabulary, partial, applied to a scene."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from pydantic import TypeAdapter, ValidationError

from engine.errors import EditError
from engine.light.base import Light
from engine.light.table import AnyLight
from engine.numerics.description import Description
from engine.scene.camera import Camera
from engine.scene.scene import Scene

_LIGHT: TypeAdapter[Any] = TypeAdapter(AnyLight)
MAX_LIGHTS = 4096


class Edits(Description):
    """What the user changed; an absent key changes nothing.

    camera       some of the camera's fields
    environment  some of the environment's fields
    lights       each {"id": ..., some fields}; a known id is changed, an unknown one is added and
                 must be complete; {"id": ..., "enabled": false} turns a light off
    materials    {material name: some of its fields}
    """

    camera: dict[str, Any] | None = None
    environment: dict[str, Any] | None = None
    lights: list[dict[str, Any]] | None = None
    materials: dict[str, dict[str, Any]] | None = None

    def touched(self) -> frozenset[str]:
        """The keys that are present: a subset of camera, environment, lights, materials."""
        return frozenset(name for name in type(self).model_fields if getattr(self, name))


def problems(error: ValidationError, prefix: str) -> EditError:
    """The first problem of a pydantic error, with the path of its field."""
    first = error.errors()[0]
    # A discriminated union puts the chosen tag first, which is no part of the user's document.
    path = [str(part) for part in first["loc"] if part != first.get("ctx", {}).get("tag")]
    return EditError(str(first["msg"]), field=".".join([prefix, *path]))


def edited_lights(
    lights: Sequence[Light], changes: Sequence[dict[str, Any]] | None
) -> tuple[Light, ...]:
    """Lights after the changes, in their old order, new ones last."""
    result = {light.id: light for light in lights}
    for index, change in enumerate(changes or ()):
        field = f"lights.{index}"
        name = change.get("id")
        if not isinstance(name, str):
            raise EditError("every light edit needs the id of its light", field=f"{field}.id")
        old = result.get(name)
        same_type = (
            old is not None
            and change.get("type", old.model_dump()["type"]) == (old.model_dump()["type"])
        )
        merged = {**(old.model_dump() if old is not None and same_type else {}), **change}
        try:
            result[name] = _LIGHT.validate_python(merged)
        except ValidationError as error:
            raise problems(error, field) from None
    if len(result) > MAX_LIGHTS:
        raise EditError(f"{len(result)} lights are more than {MAX_LIGHTS}", field="lights")
    return tuple(result.values())


def edited_camera(camera: Camera, change: dict[str, Any] | None) -> Camera:
    """The camera after the change."""
    try:
        return Camera.model_validate({**camera.model_dump(), **(change or {})})
    except ValidationError as error:
        raise problems(error, "camera") from None


def apply(scene: Scene, edits: Edits) -> Scene:
    """The scene after all edits; what did not change is shared with the old one."""
    raise NotImplementedError
