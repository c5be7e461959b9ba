"""What `relight bench` times of `wavelet_brdf` beyond moved lights and cameras."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

from engine.brdf.built_in import BUILT_IN
from engine.brdf.measured import Measured
from engine.brdf.table import INDEX
from engine.measure.code_rates import LEVELS, MATERIAL, frames_per_second, values_per_second
from engine.measure.code_stage import measured
from engine.measure.fresh import fresh
from engine.measure.settings import settings_from
from engine.methods import METHODS
from engine.methods.base import Progress, silent
from engine.methods.wavelet_brdf import Settings, Wavelets
from engine.scene.edits import Edits
from engine.scene.scene import Scene

SWITCHES = 4
PAIRS = 1 << 18


def sitting(
    product: Wavelets, scene: Scene, settings: Settings, progress: Progress = silent
) -> dict[str, float]:
    """Median seconds: another material, never seen and seen before, and a moved light by level."""
    found = _switches(product, scene)
    if scene.lights and hasattr(scene.lights[0], "position"):
        for level in range(LEVELS):
            chosen = {**asdict(settings), "detail": "finest", "level": float(level)}
            kind = METHODS[product.method].settings
            with fresh(scene, product.method, settings_from(kind, chosen), progress) as made:
                name = "a light moved, finest level" if level == 0 else f"  level {level}"
                found[name] = 1.0 / frames_per_second(made.product, "light", None)
    return found


def _switches(product: Wavelets, scene: Scene) -> dict[str, float]:
    """A material that something is made of turns to other metals; then to the same ones again."""
    name = scene.material_names[int(np.bincount(scene.geometry.material).argmax())]
    metals: list[Mapping[str, Any]] = [
        {"type": "ward", "roughness": round(0.13 + 0.07 * k, 3), "roughness_v": 0.21}
        for k in range(SWITCHES)
    ]
    found = {}
    for what in ("another material, new", "another material, known"):
        took = []
        for metal in metals:
            edits = Edits(materials={name: dict(metal)})
            took.append(product.relight(edits).timings["total"])
        found[what] = float(np.median(took))
    return found


def code_over_formula() -> float:
    """Time for a value of the built-in plastic's code, over that for one of its formula."""
    formula = BUILT_IN[MATERIAL]
    by_code = values_per_second(measured(MATERIAL).row(), INDEX[Measured], PAIRS)
    return values_per_second(formula.row(), INDEX[type(formula)], PAIRS) / by_code
