"""Build a scene from its description."""

from __future__ import annotations

import numpy as np

from engine.brdf.diffuse import Diffuse
from engine.light.environment import Environment
from engine.scene import shapes
from engine.scene.description import SceneDescription, split
from engine.scene.geometry import assemble
from engine.scene.scene import Scene
from engine.scene.tables import material_table


def build(description: SceneDescription) -> Scene:
    """Read what the description names and lay it out flat."""
    names = list(description.materials)
    materials = [split(material)[0] for material in description.materials.values()]
    if any(thing.material is None for thing in description.objects):
        names.append("grey")
        materials.append(Diffuse())
    placed = [
        (shapes.make(thing.mesh), thing.matrix(), names.index(thing.material or "grey"), index)
        for index, thing in enumerate(description.objects)
    ]
    environment = None
    if description.environment is not None and not isinstance(description.environment.map, str):
        radiance = np.array(description.environment.map, np.float32).reshape(1, 1, 3)
        environment = Environment(description.environment, radiance)
    return Scene(
        name=description.name,
        camera=description.camera,
        geometry=assemble(placed),
        material_table=material_table(materials, [{} for _ in materials]),
        material_names=tuple(names),
        materials=tuple(materials),
        object_names=tuple(thing.name for thing in description.objects),
        lights=tuple(description.lights or ()),
        environment=environment,
    )
