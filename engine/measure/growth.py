"""How cost grows: one thing is made larger at a time, and everything is measured again.

What grows is either a setting of the method or the scene itself: its picture, its triangles, its
lights. The rest stands at the method's defaults and the scene as it is.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from engine.errors import InputError
from engine.measure import levels
from engine.measure.points import Point
from engine.measure.probes import held_out_edits, held_out_turns, held_out_views, many_lights
from engine.measure.settings import settings_from
from engine.measure.sweep import REFERENCE_ERROR, along, measure
from engine.measure.trial import Trial, masks_of, trial_of
from engine.methods import METHODS
from engine.methods.base import Progress, silent
from engine.scene.edits import Edits, edited_camera
from engine.scene.geometry import Placed, assemble
from engine.scene.part import Part
from engine.scene.scene import Geometry, Scene
from engine.scene.shapes import Sphere, make
from engine.store import Store

METHOD = "direct_to_indirect"
BALLS = 5  # along each axis
CLEAR = 3.0  # radii between the camera and the nearest ball


SETTINGS: dict[str, dict[str, tuple[float, ...]]] = {
    "direct_to_indirect": {
        "gather_samples": (4096, 16384, 65536, 262144),
        "coefficients": (25, 50, 100, 200, 400),
    },
    "glossy_prt": {
        "terms": (1, 2, 4, 8, 16),
        "coefficients": (32, 64, 128, 256, 512),
    },
}
"""Per method: its settings that grow, and their values."""

SCENES: dict[str, dict[str, tuple[float, ...]]] = {
    "direct_to_indirect": {
        "view_samples": (1 / 16, 1 / 4, 1.0, 4.0),
        "triangles": (10_000, 40_000, 160_000, 640_000, 2_000_000),
        "lights": (1, 10, 100, 1000),
    },
    "glossy_prt": {"vertices": (5_000, 10_000, 20_000, 50_000, 100_000, 200_000)},
}
"""Per method: what grows of the scene; of view samples parts of the picture's own pixels, vertices
of its largest object."""


@dataclass(frozen=True)
class Grown:
    """One thing at one size.

    size   what it came to: pixels, settings' values, triangles, lights or vertices
    floor  the smallest error that the references let one see; 0 without references
    point  as in a sweep; its knob is what grew
    """

    size: int
    floor: float
    point: Point


def growth(
    scene: Scene,
    *,
    method: str = METHOD,
    fixed: Mapping[str, Any] | None = None,
    axes: Mapping[str, Sequence[float]] | None = None,
    edits: int = 2,
    seed: int = 1,
    reference_error: float = REFERENCE_ERROR,
    store: Store | None = None,
    progress: Progress = silent,
) -> list[Grown]:
    """Measure every size of every axis; arguments as in `engine.measure.sweep.sweep`.

    A method that carries no lights is timed alone, for turns of the environment and for new views.
    """
    if method not in SETTINGS:
        raise InputError(f"there is no such chart of {method}", field="method")
    fixed, settings_of, scenes_of = fixed or {}, SETTINGS[method], SCENES[method]
    cases = [
        (axis, value)
        for axis, values in ({**scenes_of, **settings_of} if axes is None else axes).items()
        for value in values
    ]
    for axis, _ in cases:
        if axis not in scenes_of and axis not in settings_of:
            known = ", ".join([*scenes_of, *settings_of])
            raise InputError(f"{axis} is nothing that grows; there are {known}", field="sweep")
    grown = []
    for number, (axis, value) in enumerate(cases):
        progress("sizes", number, len(cases))
        larger = _grown_scene(scene, axis, value, seed)
        extra = {**along(method, axis, value), axis: value} if axis in settings_of else {}
        settings = settings_from(METHODS[method].settings, {**fixed, **extra})
        if "lights" in METHODS[method].edits:
            moves = (
                _moves_of_one(larger, edits, seed)
                if axis == "lights"
                else held_out_edits(larger, edits, seed)
            )
            views = []
            trial = trial_of(larger, moves, reference_error, store or Store(), progress)
        else:
            moves = held_out_turns(larger, edits, seed)
            views = held_out_views(larger, edits, seed)
            trial = Trial(larger, moves, [], masks_of(larger, moves), [], [])
        point = measure(trial, method, axis, settings, progress, views)
        floor = max(trial.floors, default=0.0)
        grown.append(Grown(_size(larger, axis, value), floor, point))
    progress("sizes", len(cases), len(cases))
    return grown


def _size(scene: Scene, axis: str, value: float) -> int:
    """What `axis` came to in the scene."""
    sizes = {
        "view_samples": scene.camera.width * scene.camera.height,
        "triangles": len(scene.geometry.triangles),
        "lights": len(scene.lights),
        "vertices": len(scene.geometry.positions),
    }
    return sizes.get(axis, int(value))


def _grown_scene(scene: Scene, axis: str, value: float, seed: int) -> Scene:
    if axis == "view_samples":
        camera, factor = scene.camera, math.sqrt(value)
        size = {"width": round(camera.width * factor), "height": round(camera.height * factor)}
        return scene.with_camera(edited_camera(camera, size))
    if axis == "triangles":
        return with_balls(scene, int(value))
    if axis == "lights":
        return scene.with_lights(many_lights(scene, int(value), seed))
    if axis == "vertices":
        return with_vertices(scene, int(value))
    return scene


def _moves_of_one(scene: Scene, count: int, seed: int) -> list[Edits]:
    """The first of the lights moved to `count` other places, the others stay."""
    places = many_lights(scene, count, seed + 1)
    first = scene.lights[0].id
    return [Edits(lights=[{"id": first, "position": light.position}]) for light in places]


def with_balls(scene: Scene, triangles: int) -> Scene:
    """The scene with BALLS³ balls hung in it, which bring it to about so many triangles.

    It looks much the same however finely they are made: all instances of one mesh, copied.
    """
    geometry = scene.geometry
    low, high = geometry.positions.min(axis=0), geometry.positions.max(axis=0)
    steps = (np.arange(BALLS) + 0.5) / BALLS
    places = np.stack(np.meshgrid(steps, steps, steps, indexing="ij"), axis=-1).reshape(-1, 3)
    places = low + places * (high - low)
    radius = 0.15 * float((high - low).min()) / BALLS
    places = places[np.linalg.norm(places - scene.camera.position, axis=1) > CLEAR * radius]
    # A ball of r rings has 4 r (r - 1) triangles.
    each = max(0, triangles - len(geometry.triangles)) / len(places)
    rings = min(512, max(3, round(0.5 + math.sqrt(0.25 + each / 4))))
    ball = make(Sphere(shape="sphere", radius=radius, rings=rings))
    placed = []
    for index, place in enumerate(places):
        matrix = np.eye(4)
        matrix[:3, 3] = place
        placed.append(Placed(ball, matrix, 0, index))
    names = tuple(f"ball {index}" for index in range(len(places)))
    balls, _ = assemble(placed, names)
    balls = balls._replace(object=balls.object + np.int32(len(scene.object_names)))
    # Nothing of the ray tracer and digest of the old geometry goes along.
    return replace(
        scene, geometry=_joined(geometry, balls), object_names=(*scene.object_names, *names)
    )


def with_vertices(scene: Scene, count: int) -> Scene:
    """The scene with its largest object in about so many vertices, see `engine.measure.levels`."""
    geometry = scene.geometry
    largest = int(np.bincount(geometry.object).argmax())
    own = geometry.object == largest
    part = Part(geometry.positions.astype(np.float64), geometry.triangles[own].astype(np.int64))
    level, _ = assemble([Placed(levels.with_vertices(part, count), np.eye(4), 0, 0)], ["level"])
    level = level._replace(
        material=level.material + geometry.material[own][0], object=level.object + np.int32(largest)
    )
    used, triangles = np.unique(geometry.triangles[~own], return_inverse=True)
    others = Geometry(
        positions=geometry.positions[used],
        triangles=triangles.reshape(-1, 3).astype(np.int32),
        normals=geometry.normals[used],
        uvs=geometry.uvs[used],
        tangents=geometry.tangents[used],
        material=geometry.material[~own],
        object=geometry.object[~own],
    )
    return replace(scene, geometry=_joined(others, level))


def _joined(a: Geometry, b: Geometry) -> Geometry:
    b = b._replace(triangles=b.triangles + np.int32(len(a.positions)))
    return Geometry(*(np.concatenate(pair) for pair in zip(a, b, strict=True)))
