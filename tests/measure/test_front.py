"""The front of a method's settings: climbed as far as it is worth it, measured once, kept."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from engine.errors import Cancelled, InputError
from engine.measure import front as module
from engine.measure.front import USUAL, Front, front, judged_by, known_front
from engine.measure.pilots import Cost
from engine.methods import METHODS
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.store import Store

METHOD = "direct_to_indirect"


class MadeUp:
    """Pilots of made-up costs, in the order in which they are asked for."""

    def __init__(self, costs: list[Cost]) -> None:
        self.costs = costs

    def __call__(self, *_: Any) -> MadeUp:
        return self

    def run(self, method: str, settings: Any) -> Cost:
        if not self.costs:
            raise Cancelled("somebody stopped it")
        return self.costs.pop(0)

    def whole(self, method: str, settings: Any, small: Cost) -> Cost:
        return small


Measure = Callable[[list[Cost]], Front]


@pytest.fixture(scope="module")
def box() -> Scene:
    return open_scene("cornell-box")


@pytest.fixture
def measure(box: Scene, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Measure:
    def measured(costs: list[Cost]) -> Front:
        monkeypatch.setattr(module, "Pilots", MadeUp(costs))
        return front(box, METHOD, METHODS[METHOD].settings(), Store(tmp_path))

    return measured


def cost(error: float, frame: float, precompute: float = 1.0) -> Cost:
    return Cost(error, frame, 1e6, precompute)


def test_the_best_are_marked_and_a_step_that_mends_nothing_is_the_last(measure: Measure) -> None:
    found = measure([cost(0.02, 0.03), cost(0.2, 0.01), cost(0.03, 0.04), cost(0.029, 0.05)])
    assert [point.label for point in found.points] == [
        USUAL, "step 1 of 6", "step 2 of 6", "step 3 of 6",
    ]  # fmt: skip
    assert [point.best for point in found.points] == [True, True, False, False]
    assert found.kinds == ("lights",)
    assert found.points[0].settings["coefficients"] == 100
    assert found.points[1].settings["coefficients"] == 12


def test_a_long_precompute_is_the_last(measure: Measure) -> None:
    found = measure([cost(0.02, 0.03), cost(0.2, 0.01, 1000.0)])
    assert len(found.points) == 2


def test_it_is_measured_once_and_goes_on_where_it_was_stopped(
    box: Scene, tmp_path: Path, measure: Measure
) -> None:
    usual = METHODS[METHOD].settings()
    with pytest.raises(Cancelled):
        measure([cost(0.02, 0.03), cost(0.2, 0.01)])
    assert known_front(box, METHOD, usual, Store(tmp_path)) is None
    found = measure([cost(0.19, 0.02)])
    assert [point.cost.error for point in found.points] == [0.02, 0.2, 0.19]
    assert measure([]) == found == known_front(box, METHOD, usual, Store(tmp_path))
    assert not list(tmp_path.glob("pilots-*")), "what pilots leave is thrown away"
    # Under another light, or with other settings, it is another.
    assert known_front(box.with_lights(()), METHOD, usual, Store(tmp_path)) is None
    other = METHODS[METHOD].settings(coefficients=7)
    assert known_front(box, METHOD, other, Store(tmp_path)) is None


def test_what_a_method_is_judged_by(box: Scene) -> None:
    assert judged_by(box, "brdf_editing") == ("materials",)
    assert judged_by(open_scene("teatray"), METHOD) == ("environment",)
    with pytest.raises(InputError, match="glossy_prt edits camera, environment; there is none"):
        judged_by(box, "glossy_prt")
