"""What there is to know about a scene, as it crosses the wire."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.as_curve import as_curve
from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.layers import LAYERS
from engine.brdf.measured import Measured
from engine.brdf.published import DARK, METALS, PLASTICS, PUBLISHED
from engine.brdf.table import INDEX, MODELS
from engine.errors import NotFound
from engine.light.far_disk import FarDisk
from engine.light.maps import BUILT_IN
from engine.light.sky import Sky
from engine.light.table import LIGHTS
from engine.light.thumbnail import thumbnail
from engine.methods import METHODS
from engine.methods.base import MaterialFit, Method
from engine.scene.edits import Edits, edited_environment
from engine.scene.pick import material_at
from server.stage import Stage
from server.stages import Stages
from server.wire import (
    EnvironmentDetail,
    JobState,
    MapSummary,
    MaterialDetail,
    MeasuredSummary,
    MethodState,
    Notice,
    Picked,
    SceneDetail,
    SceneSummary,
)


def scene_summary(stage: Stage, stages: Stages) -> SceneSummary:
    """What a list of scenes says of one."""
    return SceneSummary(
        name=stage.name,
        description=stage.description,
        default=stage is stages.default,
        sent=stage.sent,
    )


def scene_detail(
    stage: Stage,
    uploads: list[MapSummary],
    measured: list[MeasuredSummary],
    job: JobState | None,
) -> SceneDetail:
    """Everything the page needs to know about a scene; opens it. The job is at its product."""
    scene = stage.scene()
    own = scene.environment
    return SceneDetail(
        name=stage.name,
        description=stage.description,
        camera=scene.camera,
        diagonal=scene.diagonal,
        lights=[light.model_dump() for light in scene.lights],
        light_types=light_types(),
        environment=EnvironmentDetail(
            description=None if own is None else own.description.model_dump(),
            maps=[*BUILT_IN, *stage.maps()],
            uploads=uploads,
            sky=Sky.model_json_schema(),
            area_light=FarDisk.model_json_schema(),
        ),
        materials=list(scene.material_names),
        material_types=material_types(),
        material_presets=material_presets(),
        measured=measured,
        objects=list(scene.object_names),
        triangles=len(scene.geometry.triangles),
        methods=method_states(stage),
        warnings=[Notice(**asdict(diagnosis)) for diagnosis in scene.diagnoses],
        job=job,
    )


def method_states(stage: Stage) -> list[MethodState]:
    """All methods, for the scene's own camera and materials."""
    camera, states = stage.scene().camera, []
    for method in METHODS.values():
        product = stage.product(camera, method.name)
        states.append(
            MethodState(
                name=method.name,
                paper=method.paper,
                edits=sorted(method.edits),
                models=models(method),
                settings={
                    name: value
                    for name, value in asdict(method.settings()).items()
                    if name in method.run_time
                },
                ready=product is not None,
                bytes=product.bytes if product is not None else 0,
            )
        )
    return states


def light_types() -> dict[str, dict[str, Any]]:
    """The JSON schema of every kind of light, by its `type`."""
    return {kind.model_fields["type"].default: kind.model_json_schema() for kind in LIGHTS}


def material_types() -> dict[str, dict[str, Any]]:
    """The JSON schema of every kind of material, by its `type`."""
    return {kind.model_fields["type"].default: kind.model_json_schema() for kind in MODELS}


def models(method: Method) -> list[str]:
    """Types of material that edits may choose: all, or those that `LAYERS` can cut."""
    free = method.refitted is not None
    able = [kind for kind in MODELS if free or LAYERS[INDEX[kind]] is not None]
    return [kind.model_fields["type"].default for kind in able]


def material_presets() -> dict[str, dict[str, dict[str, Any]]]:
    """Groups of materials to choose from, as edits take them, without what they emit."""
    groups: dict[str, dict[str, Material]] = {
        "Matt": {"plain diffuse": Diffuse(emission=DARK)},
        "Metals": METALS,
        "Plastics": PLASTICS,
        "Wang et al. 2006": PUBLISHED,
    }
    return {
        group: {name: known.model_dump(exclude={"emission"}) for name, known in members.items()}
        for group, members in groups.items()
    }


def material_details(
    stage: Stage, edits: Edits, method: str, name_of: Callable[[str], str]
) -> list[MaterialDetail]:
    """The materials under the edits, and how the method models those that something is made of.

    name_of  what edits call a file
    """
    scene = stage.with_materials(edits.materials)
    product = stage.product(stage.camera(edits), method, edits.materials)
    found: tuple[MaterialFit, ...] = product.fits if product is not None else ()
    refitted = METHODS[method].refitted
    if product is not None and refitted is not None and edits.materials:
        found = refitted(product, scene.materials)
    fits = {fit.name: asdict(fit) for fit in found}
    return [
        MaterialDetail(
            **{"name": name, **fits.get(name, {})},
            description=_described(material, name_of),
            curve=as_curve(material).model_dump(),
        )
        for name, material in zip(scene.material_names, scene.materials, strict=True)
    ]


def _described(material: Material, name_of: Callable[[str], str]) -> dict[str, Any]:
    described = material.model_dump()
    if isinstance(material, Measured):
        described["file"] = name_of(material.file)
    return described


def picked(stage: Stage, edits: Edits, x: float, y: float) -> Picked:
    """What the camera under the edits shows at (x, y), both from 0 to 1."""
    seen = stage.scene().with_camera(stage.camera(edits))
    return Picked(material=material_at(seen, x, y))


def map_thumbnail(stage: Stage, edits: Edits) -> NDArray[np.uint8]:
    """A small picture of the map under edits that say where it is; NotFound where there is none."""
    scene = stage.scene()
    environment = edited_environment(scene.environment, edits.environment, Path(scene.folder))
    if environment is None:
        raise NotFound("the scene has no environment")
    return thumbnail(environment)
