"""Edits of materials that no precompute has seen: the same seed draws the same ones.

The scene's materials take turns. A matt one gets another colour and, every second time, gloss; a
glossy one other colours, and another sharpness within what is neither matt nor a mirror.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from engine.brdf.base import Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.diffuse import Diffuse
from engine.brdf.layers import LAYERS
from engine.brdf.table import INDEX
from engine.errors import SceneError
from engine.scene.edits import Edits
from engine.scene.scene import Scene

DARKEST, BRIGHTEST = 0.05, 0.8
SPECULAR = 0.02, 0.5
RANGES = {"roughness": (0.15, 0.7), "exponent": (10.0, 400.0), "exponent_u": (10.0, 400.0)}


def held_out_materials(scene: Scene, count: int, seed: int) -> list[Edits]:
    """`count` edits of one material each; raises SceneError where none can be edited."""
    rng = np.random.default_rng(seed)
    able = [m for m, material in enumerate(scene.materials) if LAYERS[INDEX[type(material)]]]
    if not able:
        raise SceneError("the scene has no material that could be edited", field="materials")
    edits = []
    for k in range(count):
        m = able[k % len(able)]
        glossy = k // len(able) % 2 == 0
        change = _drawn(scene.materials[m], glossy, rng)
        edits.append(Edits(materials={scene.material_names[m]: change}))
    return edits


def _drawn(old: Material, glossy: bool, rng: np.random.Generator) -> dict[str, Any]:
    kind = type(old)
    if kind is Diffuse:
        if not glossy:
            return {"diffuse": _colour(rng, DARKEST, BRIGHTEST)}
        kind = BlinnPhong
    specular = _colour(rng, *SPECULAR)
    # No more than all is reflected, whatever the model.
    diffuse = tuple(
        round(d * (1 - s), 3)
        for d, s in zip(_colour(rng, DARKEST, BRIGHTEST), specular, strict=True)
    )
    change: dict[str, Any] = {
        "type": kind.model_fields["type"].default,
        "diffuse": diffuse,
        "specular": specular,
    }
    for name, (low, high) in RANGES.items():
        if name in kind.model_fields:
            change[name] = round(float(low * (high / low) ** rng.random()), 3)
    if "exponent_v" in kind.model_fields:
        # The grain's proportions stay: the width is what is edited.
        old_u, old_v = (getattr(old, f"exponent_{axis}") for axis in "uv")
        change["exponent_v"] = min(500.0, round(change["exponent_u"] * old_v / max(old_u, 1), 3))
    return change


def dragged(change: dict[str, Any], step: float) -> dict[str, Any]:
    """The change with its diffuse colour moved on, round and round between the bounds."""
    span = BRIGHTEST - DARKEST
    colour = change.get("diffuse", (0.5, 0.5, 0.5))
    return {**change, "diffuse": tuple(DARKEST + (c - DARKEST + step) % span for c in colour)}


def _colour(rng: np.random.Generator, low: float, high: float) -> tuple[float, ...]:
    return tuple(round(float(c), 3) for c in rng.uniform(low, high, 3))
