"""Each part of a product is stored by itself: what it does not depend on leaves it as it is."""

from __future__ import annotations

import dataclasses
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest
from methods.scenes import cornell

from engine.methods import METHODS, prepare
from engine.scene.scene import Scene
from engine.store import Store

OTHERS: dict[str, dict[str, Any]] = {
    "direct_to_indirect": {
        "gather_samples": 256,
        "cloud": "importance",
        "coefficients": 9,
        "bounce_coefficients": 9,
        "bounces": 1,
        "position_weight": 3.0,
        "gather": "links",
        "view_rays": 40,
        "gloss_rays": 40,
        "bounce_rays": 40,
        "opening_rays": 100,
        "gloss_coefficients": 9,
        "link_size": 0.1,
        "bounce_link_size": 0.2,
        "patch_size": 1.0,
        "seed": 2,
    },
    "brdf_editing": {
        "bands": 32,
        "second_bands": 4,
        "basis": "boxes",
        "bounces": 1,
        "view_rays": 40,
        "lobe_rays": 0.1,
        "lobe_exponent": 50,
        "gather_samples": 256,
        "bounce_rays": 40,
        "bounce_coefficients": 9,
        "position_weight": 3.0,
        "seed": 2,
    },
}
"""Another value of every setting than `SMALL` has."""

SMALL: dict[str, dict[str, Any]] = {
    "direct_to_indirect": {
        "gather_samples": 1024,
        "view_rays": 32,
        "gloss_rays": 32,
        "bounce_rays": 32,
    },
    "brdf_editing": {
        "gather_samples": 1024,
        "view_rays": 32,
        "bounce_rays": 32,
        "second_bands": 8,
    },
}
MADE_BY = {name: import_module(f"engine.methods.{name}.precompute") for name in OTHERS}


@pytest.fixture(scope="module")
def box() -> Scene:
    """One light, and a knot of which some is glossy."""
    box = cornell(24)
    return box.with_lights(box.lights[1:])


def stored(scene: Scene, method: str, changed: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Per part the arrays that a precompute leaves in a store; None where it makes no such part."""
    settings = METHODS[method].settings(**{**SMALL[method], **changed})
    prepare(scene, method, settings, store=Store(folder))
    of = MADE_BY[method]
    return {
        part: Store(folder).entry(of.key(scene, settings, part)).read(part) for part in of.NEEDS
    }


@pytest.mark.parametrize("method", OTHERS)
def test_a_part_depends_on_what_it_needs_alone(box: Scene, tmp_path: Path, method: str) -> None:
    fields = {field.name for field in dataclasses.fields(METHODS[method].settings)}
    assert fields == set(OTHERS[method])
    needs = MADE_BY[method].NEEDS
    before = stored(box, method, {}, tmp_path / "before")
    assert sum(part is not None for part in before.values()) >= 3
    for name, value in OTHERS[method].items():
        after = stored(box, method, {name: value}, tmp_path / name)
        for part, found in after.items():
            if name in needs[part] or before[part] is None or found is None:
                continue
            for array in found.arrays:
                same = found.arrays[array].tobytes() == before[part].arrays[array].tobytes()
                assert same, f"{part} depends on {name}"


@pytest.mark.parametrize("method", OTHERS)
def test_another_setting_makes_only_what_needs_it(box: Scene, tmp_path: Path, method: str) -> None:
    made: set[str] = set()

    def progress(phase: str, done: float, total: float) -> None:
        made.add(phase)

    small = SMALL[method]
    prepare(box, method, METHODS[method].settings(**small), store=Store(tmp_path))
    changed = METHODS[method].settings(**{**small, "view_rays": 40})
    prepare(box, method, changed, progress, store=Store(tmp_path))
    viewed = {"direct_to_indirect": "final", "brdf_editing": "links"}[method]
    assert made & set(MADE_BY[method].NEEDS) == {viewed}
