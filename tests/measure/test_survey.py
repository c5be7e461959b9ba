"""A survey climbs every ladder as far as it is worth it, and says how a plan came out."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from engine.measure import survey as module
from engine.measure.ladders import rungs
from engine.measure.pilots import Cost
from engine.measure.planner import Plan
from engine.measure.points import MAIN_ERROR, PLAN, RUNG, Point
from engine.measure.survey import LONGEST, kinds_of, survey
from engine.measure.timing import Timing
from engine.measure.trial import Trial
from engine.measure.truth import Truth
from engine.scene.edits import edited_camera
from engine.scene.open import open_scene


@pytest.mark.parametrize(
    ("scene", "kinds"),
    [
        ("cornell-box", ["lights", "materials"]),
        ("teatray", ["environment", "camera", "materials"]),
        ("ring", ["lights", "environment", "materials"]),
    ],
)
def test_what_one_would_edit(scene: str, kinds: list[str]) -> None:
    assert [kind for (kind,) in kinds_of(open_scene(scene))] == kinds


def surveyed(
    monkeypatch: pytest.MonkeyPatch, errors: dict[str, list[float]], seconds: float = 1.0
) -> dict[str, Any]:
    """A survey of made-up errors, per method those of its rungs; frames take 10 ms a rung."""
    scene = open_scene("cornell-box")
    scene = scene.with_camera(edited_camera(scene.camera, {"width": 8, "height": 8}))
    asked = dict.fromkeys(errors, 0)

    def measure(
        trial: Trial, method: str, knob: str, settings: Any, progress: Any, repeats: int
    ) -> Point:
        if knob == PLAN:
            return point(method, knob, 0.04, 0.015, seconds)
        k = asked[method]
        asked[method] += 1
        return point(method, knob, errors[method][k], 0.01 * (k + 1), seconds)

    def trial_of(scene: Any, edits: Any, *_: Any) -> Trial:
        image = 0.5 * np.ones((8, 8, 3), np.float32)
        truth = Truth(image, 0 * image, 0.0, 0.0, 1)
        kept = np.ones((8, 8), bool)
        return Trial(scene, edits, [truth] * len(edits), [kept] * len(edits), [], [])

    cost = Cost(0.03, 0.02, 1e6, 10.0)
    planned = Plan("direct_to_indirect", ("lights",), 0.05, None, cost, True, (), (), 3, 1.0)
    monkeypatch.setattr(module, "trial_of", trial_of)
    monkeypatch.setattr(module, "measure", measure)
    monkeypatch.setattr(module, "others", lambda *_: [])
    monkeypatch.setattr(Plan, "as_dict", lambda self: {"budget": self.budget})
    return survey(scene, planned)


def point(method: str, knob: str, error: float, frame: float, seconds: float) -> Point:
    errors = {MAIN_ERROR: error}
    return Point(method, knob, {}, errors, [errors], Timing((frame,)), {}, 1, seconds, [])


def rungs_in(document: dict[str, Any], method: str) -> list[int]:
    return [
        p["settings"][RUNG]
        for p in document["points"]
        if p["method"] == method and p["knob"] == RUNG
    ]


def test_a_ladder_is_left_where_it_mends_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    errors = {
        "direct_to_indirect": [0.2, 0.1, 0.045, 0.02, 0.01, 0.005],
        "brdf_editing": [0.3, 0.04, 0.039],
        "wavelet_brdf": [0.5, 0.5],
    }
    found = surveyed(monkeypatch, errors)
    assert rungs_in(found, "direct_to_indirect") == list(range(rungs("direct_to_indirect")))
    assert rungs_in(found, "brdf_editing") == [0, 1, 2]
    assert rungs_in(found, "wavelet_brdf") == [0, 1]
    plan = found["plan"]
    assert plan["kept"]
    assert plan["best_swept_frame"] == 0.02, "of those that hold 5 %"
    assert plan["measured"] == {"error": 0.04, "frame": 0.015, "bytes": 1, "precompute": 1.0}
    assert found["kinds"] == ["lights"]


def test_a_ladder_is_left_where_it_takes_too_long(monkeypatch: pytest.MonkeyPatch) -> None:
    errors = {name: [0.2] for name in ("direct_to_indirect", "brdf_editing", "wavelet_brdf")}
    found = surveyed(monkeypatch, errors, LONGEST + 1)
    assert all(rungs_in(found, name) == [0] for name in errors)
    assert found["plan"]["best_swept_frame"] is None
