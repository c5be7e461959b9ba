"""How accurate `glossy_prt` is: materials, environments, light paths and settings, one by one.

Every point is a precompute of one material with one setting changed. All environments are edits of
it, judged against the path tracer, whose paths are cut off after as many bounces as the method
follows, and also against light that is followed to its end. Edges are left out, as is what the
camera sees of the environment itself, and the noise of the references is taken out.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.errors import InputError
from engine.measure.document import finite, provenance
from engine.measure.edges import scene_edges, seen_objects
from engine.measure.fresh import fresh
from engine.measure.machine import this_machine
from engine.measure.metrics import relative_l2, resolution
from engine.measure.stage import MATERIALS, OBJECT, Thing, ball, stage
from engine.measure.sweep import REFERENCE_ERROR, variants
from engine.measure.truth import Truth, truth
from engine.methods.base import Progress, silent
from engine.scene.edits import Edits
from engine.scene.scene import Scene
from engine.store import Store

METHOD = "glossy_prt"
MAPS = (".exr", ".hdr")
SIZE, CUTS, RINGS = (128, 128), 96, 64


@dataclass(frozen=True)
class Transport:
    """Which paths of light are followed: on a lone ball, whose sky nothing hides, or on a floor."""

    alone: bool
    bounces: int

    @property
    def limits(self) -> tuple[int | None, ...]:
        """Reflections after which references cut light off; None for those that do not."""
        return (self.bounces + 1,) if self.alone else (self.bounces + 1, None)


TRANSPORTS = {
    "unoccluded": Transport(alone=True, bounces=0),
    "direct": Transport(alone=False, bounces=0),
    "1 bounce": Transport(alone=False, bounces=1),
    "2 bounces": Transport(alone=False, bounces=2),
}

SWEEPS: dict[str, tuple[str, tuple[int, ...]]] = {
    "terms": ("direct", (1, 2, 4, 8, 16)),
    "coefficients": ("direct", (32, 64, 128, 256, 512)),
    "light_texels": ("direct", (16, 32, 64)),
    "gather_texels": ("1 bounce", (8, 16, 32, 64)),
}
"""Settings that are swept: with which transport, over which values."""


@dataclass(frozen=True)
class Pixels:
    """Which pixels count, (h, w) bool: all that show a surface and no edge, and each object's."""

    whole: NDArray[np.bool_]
    parts: dict[str, NDArray[np.bool_]]


BUILT_IN: dict[str, Any] = {"studio": "studio", "sky": {"sun_direction": (0.6, -0.7, -0.4)}}
"""Environments where no folder of maps is given."""


def environments_in(folder: Path | None) -> dict[str, Edits]:
    """The maps of a folder as edits by name; InputError where there is none."""
    if folder is None:
        return {name: Edits(environment={"map": made}) for name, made in BUILT_IN.items()}
    found = sorted(p for p in folder.glob("*") if p.suffix.lower() in MAPS)
    if not found:
        raise InputError(f"there is no map of type {' or '.join(MAPS)}", file=str(folder))
    return {path.stem: Edits(environment={"map": path.name}) for path in found}


def study(
    thing: Thing,
    environments: Mapping[str, Edits],
    size: tuple[int, int] = SIZE,
    *,
    folder: Path = Path(),
    materials: Mapping[str, Material] = MATERIALS,
    cuts: int = CUTS,
    rings: int = RINGS,
    fixed: Mapping[str, Any] | None = None,
    knobs: Mapping[str, Sequence[Any]] | None = None,
    reference_error: float = REFERENCE_ERROR,
    store: Store | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """All points as JSON.

    thing            the object that stands on the floor
    environments     edits by name, whose maps lie in `folder`
    size             width and height of the pictures
    cuts, rings      of the floor along a side, and of the ball from pole to pole
    fixed            settings that hold for every point
    knobs            what to sweep in place of SWEEPS, of the settings that are in it
    reference_error  relative L2 error that the references are rendered to
    store            where references are kept
    """
    swept, kept = _swept(knobs), store or Store()
    points: list[dict[str, Any]] = []
    references: list[dict[str, Any]] = []
    vertices = {}

    def measure(at: dict[str, str], scene: Scene, transport: Transport) -> None:
        """Add all points of one material and one transport."""
        pixels = counted(scene)
        truths = {
            limit: {
                name: truth(scene, edit, reference_error, kept, progress, max_bounces=limit)
                for name, edit in environments.items()
            }
            for limit in transport.limits
        }
        references.extend(
            {**at, "environment": environment, "max_bounces": limit, **_reference(found, pixels)}
            for limit, under in truths.items()
            for environment, found in under.items()
        )
        values = {knob: v for knob, (where, v) in swept.items() if where == at["transport"]}
        if isinstance(scene.materials[OBJECT], Diffuse):
            values.pop("terms", None)  # one is exact
        # Passes that are asked for are made, however little they bring.
        usual = {"remaining": 0.0, **(fixed or {}), "bounces": transport.bounces}
        for knob, settings in variants(METHOD, usual, values):
            found = _point(scene, settings, environments, truths, pixels, progress)
            points.append({**at, "knob": knob, **found})

    for number, (material_name, material) in enumerate(materials.items()):
        progress("materials", number, len(materials))
        for name, transport in TRANSPORTS.items():
            shape, floor = (ball(rings), None) if transport.alone else (thing, cuts)
            scene = stage(shape, material, size, cuts=floor, folder=folder)
            vertices[scene.name] = len(scene.geometry.positions)
            measure({"material": material_name, "transport": name}, scene, transport)
    progress("materials", len(materials), len(materials))
    return finite(
        {
            **provenance(),
            "machine": this_machine().as_dict(),
            "method": METHOD,
            "width": size[0],
            "height": size[1],
            "vertices": vertices,
            "seed": 0,  # of the references; nothing else is drawn
            "reference_error": reference_error,
            "materials": {name: m.model_dump(mode="json") for name, m in materials.items()},
            "environments": list(environments),
            "references": references,
            "points": points,
        }
    )


def counted(scene: Scene) -> Pixels:
    """The pixels of a stage that count."""
    seen, edges = seen_objects(scene), scene_edges(scene)
    parts = {name: (seen == index) & ~edges for index, name in enumerate(scene.object_names)}
    return Pixels((seen >= 0) & ~edges, parts)


def error(image: NDArray[np.float32], reference: Truth, mask: NDArray[np.bool_]) -> float:
    """Relative L2 over the masked pixels, without the noise of the reference; NaN for none."""
    if not mask.any():
        return math.nan
    return relative_l2(image, reference.image, mask, reference.variance)


def _swept(
    knobs: Mapping[str, Sequence[Any]] | None,
) -> dict[str, tuple[str, Sequence[Any]]]:
    if knobs is None:
        return dict(SWEEPS)
    for knob in knobs:
        if knob not in SWEEPS:
            raise InputError(f"{knob} is not swept; there are {', '.join(SWEEPS)}", field="sweep")
    return {knob: (SWEEPS[knob][0], values) for knob, values in knobs.items()}


def _reference(reference: Truth, pixels: Pixels) -> dict[str, float]:
    return {
        "error": reference.error,
        "floor": resolution(reference.image, reference.variance, pixels.whole),
        "seconds": reference.seconds,
        "samples": reference.samples,
    }


def _point(
    scene: Scene,
    settings: Any,
    environments: Mapping[str, Edits],
    truths: Mapping[int | None, Mapping[str, Truth]],
    pixels: Pixels,
    progress: Progress,
) -> dict[str, Any]:
    """Errors of one precompute under all environments."""
    limit = settings.bounces + 1
    errors: dict[str, dict[str, float]] = {}
    with fresh(scene, METHOD, settings, progress) as made:
        for name, edit in environments.items():
            image, same = made.product.relight(edit).image, truths[limit][name]
            found = {"relative_l2": error(image, same, pixels.whole)}
            found |= {part: error(image, same, mask) for part, mask in pixels.parts.items()}
            if None in truths:
                found["of_all_bounces"] = error(image, truths[None][name], pixels.whole)
            errors[name] = found
        return {
            "settings": asdict(settings),
            "errors": errors,
            "bytes": made.product.bytes,
            "precompute_seconds": made.seconds,
        }
