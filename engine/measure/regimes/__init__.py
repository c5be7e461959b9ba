"""Where methods fail and where they do not, each case with its bound: what is said of stability."""

from __future__ import annotations

from engine.measure.regimes.at_ease import AT_EASE
from engine.measure.regimes.geometry import GEOMETRY
from engine.measure.regimes.gloss import GLOSS
from engine.measure.regimes.lights import LIGHTS
from engine.measure.regimes.materials import MATERIALS
from engine.measure.regimes.regime import BUDGET, Mend, Outcome, Regime, run
from engine.measure.regimes.together import TOGETHER

GROUPS: dict[str, tuple[Regime, ...]] = {
    "lights": LIGHTS,
    "gloss": GLOSS,
    "geometry": GEOMETRY,
    "materials": MATERIALS,
    "together": TOGETHER,
    "at ease": AT_EASE,
}
"""Regimes by what breaks; of the last nothing does."""

REGIMES: tuple[Regime, ...] = tuple(regime for group in GROUPS.values() for regime in group)

__all__ = ["BUDGET", "GROUPS", "REGIMES", "Mend", "Outcome", "Regime", "run"]
