"""Pilots see what whole pictures show, and make no more than their settings ask for."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from engine.measure import pilots
from engine.measure.pilots import Cost, Pilots
from engine.measure.sweep import measure
from engine.measure.trial import Trial, trial_of
from engine.measure.truth import Truth
from engine.methods.base import silent
from engine.methods.direct_to_indirect import Settings
from engine.scene.edits import Edits, edited_camera
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.store import Store

SETTINGS = Settings(gather_samples=1024, coefficients=25, gloss_coefficients=20, bounces=1)
NOISE = 0.15


@pytest.fixture(scope="module")
def knot() -> Scene:
    scene = open_scene("knot")
    return scene.with_camera(edited_camera(scene.camera, {"width": 96, "height": 96}))


@pytest.mark.sweep
def test_a_pilot_is_as_far_off_as_the_whole_picture(
    knot: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its few pixels are as small: a picture of 48 large ones is a third less off."""
    monkeypatch.setattr(pilots, "SIDE", 48)
    store = Store(tmp_path)
    found = Pilots(knot, ["environment"], NOISE, store, silent)
    cost = found.run("direct_to_indirect", SETTINGS)
    trial = trial_of(knot, found._trial.edits, NOISE, store, silent)
    whole = measure(trial, "direct_to_indirect", "", SETTINGS, silent, repeats=1)
    assert cost.error == pytest.approx(whole.error["relative_l2"], rel=0.2)
    # Among edits, and because they are few pixels, and their references noisy.
    among = (
        pilots.SURELY
        * math.sqrt(2 / len(whole.errors))
        * np.std([error["relative_l2"] for error in whole.errors], ddof=1)
    )
    assert 0.5 * among < cost.doubt < cost.error


def test_direct_light_is_off_as_a_part_of_what_is_seen_of_it(knot: Scene) -> None:
    """However much of the picture is edges or dark; unseen light as that of other edits."""
    edits = [Edits(), Edits(), Edits()]
    lit = Trial(knot.with_environment(None), edits, [], [], [], [])
    shape = knot.camera.height, knot.camera.width
    blank = Truth(np.zeros((*shape, 3), np.float32), np.zeros((*shape, 3), np.float32), 0.1, 1, 1)
    drawn = pilots._drawn(replace(lit, truths=[blank]), 0)
    dark = drawn.max(axis=2) == 0
    few = dark.copy()
    few[np.nonzero(~dark)[0][0]] = True
    truths = [replace(blank, image=drawn / 1.1), replace(blank, image=drawn / 1.2)]
    kept = [few, np.ones(shape, np.bool_), dark]
    found = pilots._drawn_off(replace(lit, truths=[*truths, truths[0]], kept=kept))
    np.testing.assert_allclose(found, [0.1, 0.2, 0.15], rtol=1e-4)


def test_what_lacks_light_is_known_without_a_pilot(
    knot: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The environment's, where it is all that there is; nothing, of a method that carries it."""
    monkeypatch.setattr(pilots, "SIDE", 24)
    no_lamps = knot.with_lights(())
    found = Pilots(no_lamps, ["environment"], NOISE, Store(tmp_path), silent)
    assert found.lacking("wavelet_brdf") == pytest.approx(1.0, abs=0.1)
    assert found.lacking("direct_to_indirect") == 0.0
    assert found.count == 0


def test_doubt_adds_to_what_other_edits_may_have() -> None:
    assert Cost(0.03, 0.1, 1e6, 1.0, doubt=0.01).most == pytest.approx(0.04)
