"""What the planner may choose of every method: its settings, from the cheapest to the dearest.

What costs time in a frame stands first, and is lowered first. Steps of what costs little are wide,
so that a rung that has enough of it has not too much of what costs a lot. A rung is one step of
all settings at once; where a setting has fewer steps than others it stays at its last one. Settings
that are not here keep their defaults.
"""

from __future__ import annotations

from typing import Any

from engine.errors import InputError
from engine.measure.settings import settings_from
from engine.measure.sweep import along
from engine.methods import METHODS

LADDERS: dict[str, dict[str, tuple[Any, ...]]] = {
    "direct_to_indirect": {
        "coefficients": (12, 25, 50, 100, 200, 400),
        "bounce_coefficients": (10, 20, 40, 80),
        "gather_samples": (1024, 4096, 16384, 65536, 262144),
        "bounces": (0, 1, 3, 8),
        "gloss_coefficients": (10, 20, 40, 80),
        "view_rays": (89, 233, 610, 1597),
        "gloss_rays": (89, 233, 610, 1597),
    },
    "glossy_prt": {
        "terms": (1, 2, 4, 8, 16),
        "cluster_error": (0.3, 0.2, 0.1, 0.05, 0.02, 0.01),
        "light_texels": (16, 32, 64),
        "bounces": (0, 1, 4),
        "gather_texels": (8, 16, 32),
    },
    "brdf_editing": {
        "gather_samples": (1024, 4096, 16384, 65536),
        "view_rays": (64, 128, 256, 512, 1024),
        "bounces": (0, 2, 5, 8),
        "second_bands": (1, 8, 16),
        "bands": (16, 32, 64, 128),
    },
    "wavelet_brdf": {
        "cells": (16, 32, 64),
        "error": (0.1, 0.03, 0.01, 0.003),
    },
}
"""Per method the steps of its settings."""


def rungs(method: str) -> int:
    """How many steps there are."""
    if method not in LADDERS:
        raise InputError(f"there is no ladder of {method}", field="method")
    return max(map(len, LADDERS[method].values()))


def rung(method: str, k: int) -> dict[str, Any]:
    """All settings at step k."""
    return {name: steps[min(k, len(steps) - 1)] for name, steps in LADDERS[method].items()}


def settings_at(method: str, chosen: dict[str, Any]) -> Any:
    """The method's settings with steps of its ladders, and what goes along with them."""
    extra: dict[str, Any] = {}
    for name, value in chosen.items():
        extra |= along(method, name, value)
    return settings_from(METHODS[method].settings, {**extra, **chosen})
