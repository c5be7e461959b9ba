"""The planner: the least that holds a budget, by pilots, and honest where nothing does."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import pytest

from engine.errors import InputError
from engine.measure import pilots, planner
from engine.measure.held_out import judged_on
from engine.measure.ladders import LADDERS, rung, rungs, settings_at
from engine.measure.pilots import Cost
from engine.measure.planner import ORDER, plan
from engine.measure.settings import settings_from
from engine.measure.sweep import measure
from engine.measure.trial import trial_of
from engine.methods import METHODS
from engine.methods.base import silent
from engine.scene.edits import edited_camera
from engine.scene.open import open_scene
from engine.store import Store


@pytest.mark.parametrize("method", LADDERS)
def test_ladders_are_of_settings_that_exist(method: str) -> None:
    assert set(LADDERS) == set(METHODS) == set(ORDER)
    for k in range(rungs(method)):
        settings_at(method, rung(method, k))


class MadeUp:
    """Pilots of a made-up error."""

    def __init__(self, error: Callable[[dict[str, Any]], float]) -> None:
        self._error, self.asked = error, 0

    def run(self, method: str, settings: Any) -> Cost:
        self.asked += 1
        return Cost(self._error(asdict(settings)), 0.01, 1, 1)


def chosen(error: Callable[[dict[str, Any]], float], budget: float) -> tuple[Any, MadeUp]:
    made_up = MadeUp(error)
    return planner._choose("direct_to_indirect", made_up, budget), made_up  # type: ignore[arg-type]


def test_the_least_is_taken_where_it_is_enough() -> None:
    choice, made_up = chosen(lambda settings: 0.01, 0.05)
    assert choice.settings == rung("direct_to_indirect", 0)
    assert choice.holds
    assert made_up.asked == 1
    assert all("the least is enough" in reason for reason in choice.reasons)


def test_what_matters_is_raised_and_nothing_else() -> None:
    """Here the error is that of few coefficients and of few bounces."""

    def error(settings: dict[str, Any]) -> float:
        return 1.0 / settings["coefficients"] + 0.02 * (settings["bounces"] < 2)

    choice, _ = chosen(error, 0.05)
    assert choice.holds
    assert choice.settings == {
        **rung("direct_to_indirect", 0), "coefficients": 25, "bounces": 3,
    }  # fmt: skip
    for name in ("coefficients", "bounces"):
        steps = LADDERS["direct_to_indirect"][name]
        lower = steps[steps.index(choice.settings[name]) - 1]
        assert error({**choice.settings, name: lower}) > 0.05
    tight, _ = chosen(error, 0.03)
    assert (tight.settings["coefficients"], tight.settings["bounces"]) == (50, 3)
    (reason,) = [r for r in tight.reasons if r.startswith("bounces")]
    assert reason == "bounces = 3: 1 would be up to 4.0 % off"


@pytest.mark.parametrize("first", range(8))
def test_the_least_step_is_found_by_halves(first: int) -> None:
    asked = []

    def error_of(k: int) -> float:
        asked.append(k)
        return 0.04 if k >= first else 0.1 + 0.01 * k

    found = planner._least(7, error_of, 0.05)
    assert found == (first, 0.1 + 0.01 * (first - 1) if first else 0.0)
    assert len(asked) <= 4
    assert planner._least(0, error_of, 0.05) == (0, 0.0)


def test_what_cannot_be_held_is_said() -> None:
    choice, made_up = chosen(lambda settings: 0.2 - 1e-3 * settings["bounces"], 0.05)
    assert not choice.holds
    assert choice.settings["bounces"] == 1
    assert choice.reasons == ["no setting comes below 19.9 %"]
    assert made_up.asked == 2, "at this rate no rung will do"


class Methods(MadeUp):
    """Pilots of methods whose error and frame do not depend on their settings."""

    def __init__(self, **methods: tuple[float, float]) -> None:
        self._methods = methods

    def run(self, method: str, settings: Any) -> Cost:
        error, frame = self._methods[method]
        return Cost(error, frame, 1, 1)

    def lacking(self, method: str) -> float:
        return 0.0

    def whole(self, method: str, settings: Any, small: Cost) -> Cost:
        return small


def best(**methods: tuple[float, float]) -> tuple[str, list[str]]:
    choice, why_not = planner._best(list(methods), Methods(**methods), 0.05, silent)  # type: ignore[arg-type]
    return choice.method, why_not


def test_a_method_is_left_for_one_of_faster_frames_alone() -> None:
    assert best(wavelet_brdf=(0.04, 0.004), brdf_editing=(0.01, 0.001)) == (
        "wavelet_brdf", ["brdf_editing was not tried: wavelet_brdf holds the budget"],
    )  # fmt: skip
    assert best(wavelet_brdf=(0.04, 0.04), brdf_editing=(0.01, 0.001)) == (
        "brdf_editing", ["wavelet_brdf holds it too, with 40 ms a frame"],
    )  # fmt: skip
    assert best(wavelet_brdf=(0.04, 0.04), brdf_editing=(0.2, 0.001)) == (
        "wavelet_brdf", ["brdf_editing is up to 20.0 % off at best"],
    )  # fmt: skip
    assert best(wavelet_brdf=(0.3, 0.04), brdf_editing=(0.2, 0.1))[0] == "brdf_editing"


def test_edits_that_no_method_takes_together_are_refused() -> None:
    scene = open_scene("cornell-box")
    with pytest.raises(InputError, match=r"brdf_editing takes no edits of environment.*Plan them"):
        plan(scene, ["environment", "materials"], 0.05)
    with pytest.raises(InputError, match="'weather' cannot be edited"):
        plan(scene, ["weather"], 0.05)
    with pytest.raises(InputError, match=r"0\.0 is not from 0\.005 to 1"):
        plan(scene, ["lights"], 0.0)
    with pytest.raises(InputError, match="say what is to be edited"):
        plan(scene, [], 0.05)


@pytest.mark.sweep
def test_a_plan_is_kept(tmp_path: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """It holds on edits that it has not seen, which are easier here than those that it drew."""
    monkeypatch.setattr(pilots, "SIDE", 48)
    scene, budget = open_scene("cornell-box"), 0.1
    camera = edited_camera(scene.camera, {"width": 72, "height": 72})
    scene, store = scene.with_camera(camera), Store(tmp_path)
    found = plan(scene, ["lights"], budget, ["direct_to_indirect", "wavelet_brdf"], store)
    assert found.holds
    assert found.method == "direct_to_indirect"
    assert "wavelet_brdf lacks light" in found.left_out[0]
    assert found.settings.gather_samples <= 4096
    scene, edits = judged_on(scene, [found.method], 4, 1)
    trial = trial_of(scene, edits, budget / 2, store, silent)
    point = measure(trial, found.method, "", found.settings, silent)
    assert point.error["relative_l2"] <= budget
    assert found.predicted.most <= budget
    assert found.predicted.error / 4 < point.error["relative_l2"] < 1.5 * found.predicted.error
    assert found.predicted.bytes == pytest.approx(point.bytes, rel=0.5)
    assert any("direct_to_indirect: " in line for line in found.lines())
    kind = METHODS[found.method].settings
    assert settings_from(kind, found.as_dict()["settings"]) == found.settings
