"""Edits: the scene's own vocabulary, partial, applied to a scene."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from engine.brdf.base import Material
from engine.brdf.table import AnyMaterial
from engine.errors import EditError, SceneError
from engine.light.base import Light
from engine.light.environment import Environment, EnvironmentDescription
from engine.light.maps import load_environment
from engine.light.table import AnyLight
from engine.numerics.description import Description
from engine.scene.albedos import albedo_diagnoses
from engine.scene.camera import Camera
from engine.scene.explain import closest, explain
from engine.scene.scene import Scene
from engine.scene.tables import changed_table

_LIGHT: TypeAdapter[Any] = TypeAdapter(AnyLight)
_MATERIAL: TypeAdapter[Any] = TypeAdapter(AnyMaterial)
MAX_LIGHTS = 4096


class Edits(Description):
    """What the user changed; an absent key changes nothing.

    camera       some of the camera's fields
    environment  some of the environment's fields, and of its area light's; null is no area light
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


def problems(
    error: ValidationError, prefix: str, document: Any = None, schema: dict[str, Any] | None = None
) -> EditError:
    """The first problem of a pydantic error, with the path of its field from `prefix` on.

    The document and its schema make for a better sentence.
    """
    field, sentence = explain(error, document, schema or {})
    return EditError(sentence, field=".".join(part for part in (prefix, field) if part))


def parse(document: Any) -> Edits:
    """Edits from what JSON holds. Raises EditError, which names the field."""
    try:
        return Edits.model_validate(document)
    except ValidationError as error:
        field, sentence = explain(error, document, Edits.model_json_schema())
        raise EditError(sentence, field=field) from None


def edited_lights(
    lights: Sequence[Light], changes: Sequence[dict[str, Any]] | None, folder: str = ""
) -> tuple[Light, ...]:
    """Lights after the changes, in their old order, new ones last.

    The files that they name lie in `folder`, which is the scene's own.
    """
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
            result[name] = _LIGHT.validate_python(merged).located(Path(folder))
        except ValidationError as error:
            raise problems(error, field, merged, _light_schema()) from None
        except SceneError as error:
            place = f"{field}.{error.field}"
            raise EditError(error.message, field=place, file=error.file) from None
    if len(result) > MAX_LIGHTS:
        raise EditError(f"{len(result)} lights are more than {MAX_LIGHTS}", field="lights")
    return tuple(result.values())


def edited_camera(camera: Camera, change: dict[str, Any] | None) -> Camera:
    """The camera after the change."""
    merged = {**camera.model_dump(), **(change or {})}
    try:
        return type(camera).model_validate(merged)
    except ValidationError as error:
        raise problems(error, "camera", merged, Camera.model_json_schema()) from None


def edited_materials(
    scene: Scene, changes: dict[str, dict[str, Any]] | None
) -> tuple[Material, ...]:
    """Materials after the changes, in the order of the scene.

    A change of type starts from the new model's defaults, but for the emission. A texture goes on
    multiplying its constant; new textures cannot be brought in by an edit.
    """
    result = list(scene.materials)
    for name, change in (changes or {}).items():
        field = f"materials.{name}"
        if name not in scene.material_names:
            raise EditError(
                f"there is no material {name!r}; {closest(name, scene.material_names)}", field=field
            )
        index = scene.material_names.index(name)
        old = result[index].model_dump()
        for key, value in change.items():
            if isinstance(value, dict):
                raise EditError(
                    "an edit can change constants only, not textures", field=f"{field}.{key}"
                )
        if change.get("type", old["type"]) != old["type"]:
            old = {"emission": old["emission"]}
        merged = {**old, **change}
        try:
            result[index] = _MATERIAL.validate_python(merged).located(Path(scene.folder))
        except ValidationError as error:
            raise problems(error, field, merged, _material_schema()) from None
        except SceneError as error:
            place = f"{field}.{error.field}"
            raise EditError(error.message, field=place, file=error.file) from None
    return tuple(result)


def edited_environment(
    environment: Environment | None, change: dict[str, Any] | None, folder: Path
) -> Environment | None:
    """The environment after the change; a map is read only where it is another one."""
    if not change:
        return environment
    old = environment.description.model_dump() if environment is not None else {}
    merged = {**old, **change}
    if isinstance(old.get("area_light"), dict) and isinstance(change.get("area_light"), dict):
        merged["area_light"] = {**old["area_light"], **change["area_light"]}
    try:
        description = EnvironmentDescription.model_validate(merged)
    except ValidationError as error:
        schema = EnvironmentDescription.model_json_schema()
        raise problems(error, "environment", merged, schema) from None
    if environment is not None and description.map == environment.description.map:
        return replace(environment, description=description)
    try:
        return load_environment(description, folder)
    except SceneError as error:
        raise EditError(error.message, field="environment.map", file=error.file) from None


def apply(scene: Scene, edits: Edits) -> Scene:
    """The scene after all edits; what did not change is shared with the old one.

    Raises EditError, which names the field.
    """
    changes: dict[str, Any] = {}
    if edits.camera:
        changes["camera"] = edited_camera(scene.camera, edits.camera)
    if edits.lights:
        changes["lights"] = edited_lights(scene.lights, edits.lights, scene.folder)
    if edits.environment:
        changes["environment"] = edited_environment(
            scene.environment, edits.environment, Path(scene.folder)
        )
    if edits.materials:
        materials = edited_materials(scene, edits.materials)
        table = changed_table(scene.material_table, materials)
        kept = [d for d in scene.diagnoses if d.code != "albedo_above_one"]
        found = albedo_diagnoses(scene.material_names, materials, table)
        changes |= {"materials": materials, "material_table": table, "diagnoses": (*kept, *found)}
    if not changes:
        return scene
    edited = replace(scene, **changes)
    shared = ["rays", "diagonal"] if edits.materials else ["rays", "diagonal", "transport_digest"]
    for name in shared:
        if name in scene.__dict__:
            edited.__dict__[name] = scene.__dict__[name]
    return edited


@cache
def _light_schema() -> dict[str, Any]:
    return _LIGHT.json_schema()


@cache
def _material_schema() -> dict[str, Any]:
    return _MATERIAL.json_schema()
