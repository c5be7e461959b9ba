"""Which method a budget asks for, and each of its settings at its least, by `pilots`.

1. Methods are tried from the one with the cheapest precompute on, until one holds with frames as
   fast as a screen shows them; else that with the fastest frames of those that hold is taken.
2. All its settings are raised together, from the least, until the error is within the budget.
3. One after the other they are lowered again as long as it stays there.
"""

from __future__ import annotations

import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from engine.errors import InputError
from engine.measure.held_out import HELD_OUT
from engine.measure.ladders import LADDERS, rung, rungs, settings_at
from engine.measure.pilots import Cost, Pilots
from engine.methods import METHODS
from engine.methods.base import Progress, silent
from engine.scene.scene import Scene
from engine.store import Store

ORDER = "wavelet_brdf", "direct_to_indirect", "glossy_prt", "brdf_editing"
NOISE = 2.0  # of the budget, in the references; it is taken out again
LEAST_ERROR = 0.005  # of a budget
SMOOTH = 1 / 60  # seconds of a frame, below which nobody sees the difference


@dataclass(frozen=True)
class Plan:
    """What would be modelled, and why.

    edits      what may be edited
    budget     relative L2 error
    settings   of the method
    predicted  for the whole picture
    holds      whether the error is within the budget, under other edits too
    reasons    why each setting is what it is
    left_out   why other methods are not taken
    pilots     how many were run
    seconds    that planning took
    """

    method: str
    edits: tuple[str, ...]
    budget: float
    settings: Any
    predicted: Cost
    holds: bool
    reasons: tuple[str, ...]
    left_out: tuple[str, ...]
    pilots: int
    seconds: float

    def as_dict(self) -> dict[str, Any]:
        """As JSON."""
        return asdict(self)

    def lines(self) -> list[str]:
        """As words."""
        cost = self.predicted
        held = "holds" if self.holds else "does NOT hold"
        return [
            f"{self.method}: {_percent(cost.error)} off, under other edits up to "
            f"{_percent(cost.most)}, which {held} {100 * self.budget:g} %; "
            f"{1000 * cost.frame:.0f} ms a frame, {cost.bytes / 1e6:.1f} MB, "
            f"{cost.precompute:.0f} s of precompute",
            *(f"  {reason}" for reason in self.reasons),
            *(f"  left out: {reason}" for reason in self.left_out),
            f"  {self.pilots} pilots, {self.seconds:.1f} s",
        ]


def plan(
    scene: Scene,
    kinds: Sequence[str],
    budget: float,
    methods: Sequence[str] | None = None,
    store: Store | None = None,
    progress: Progress = silent,
) -> Plan:
    """The cheapest settings of the fastest method that holds the budget, or the best there is.

    kinds    what may be edited: some of camera, environment, lights, materials
    methods  to choose from, in place of all
    store    where references are kept

    Raises InputError where no method takes all these edits.
    """
    start = time.perf_counter()
    if not LEAST_ERROR <= budget < 1:
        raise InputError(f"{budget} is not from {LEAST_ERROR} to 1", field="error")
    candidates, left_out = _candidates(kinds, methods)
    with tempfile.TemporaryDirectory(prefix="relight-plan-") as folder:
        scratch = Store(Path(folder))
        pilots = Pilots(scene, kinds, NOISE * budget, store or Store(), progress, scratch)
        best, why_not = _best(candidates, pilots, budget, progress)
    return Plan(
        best.method, tuple(kinds), budget, settings_at(best.method, best.settings), best.cost,
        best.holds, tuple(best.reasons), (*left_out, *why_not), pilots.count,
        time.perf_counter() - start,
    )  # fmt: skip


@dataclass(frozen=True)
class _Choice:
    method: str
    settings: dict[str, Any]
    cost: Cost
    holds: bool
    reasons: list[str]


def _candidates(kinds: Sequence[str], methods: Sequence[str] | None) -> tuple[list[str], list[str]]:
    """(methods that take all these edits, why others do not)."""
    for kind in kinds:
        if kind not in HELD_OUT:
            raise InputError(f"{kind!r} cannot be edited; {', '.join(HELD_OUT)} can", field="edits")
    if not kinds:
        raise InputError(f"say what is to be edited: {', '.join(HELD_OUT)}", field="edits")
    able, unable = [], []
    for name in sorted(ORDER if methods is None else methods, key=ORDER.index):
        missing = [kind for kind in kinds if kind not in METHODS[name].edits]
        if missing:
            unable.append(f"{name} takes no edits of {' and '.join(missing)}")
        else:
            able.append(name)
    if not able:
        raise InputError(
            f"no method takes edits of {', '.join(kinds)} together: {'; '.join(unable)}. Plan them "
            "apart.",
            field="edits",
        )
    return able, unable


def _best(
    candidates: Sequence[str], pilots: Pilots, budget: float, progress: Progress
) -> tuple[_Choice, list[str]]:
    """(the fastest method that holds the budget or what is nearest, why others are not taken)."""
    found: list[_Choice] = []
    left_out = []
    smooth: str | None = None
    for number, method in enumerate(candidates):
        progress("methods", number, len(candidates))
        lacking = pilots.lacking(method)
        if smooth:
            left_out.append(f"{method} was not tried: {smooth} holds the budget")
        elif lacking > budget and len(candidates) > 1:
            left_out.append(f"{method} lacks light that is {_percent(lacking)} of the picture")
        else:
            choice = _choose(method, pilots, budget)
            if choice.holds:
                choice = _whole(choice, pilots)
                smooth = method if choice.cost.frame <= SMOOTH else None
            found.append(choice)
    progress("methods", len(candidates), len(candidates))
    best = min(found, key=_rank)
    left_out += [_beaten(other) for other in found if other is not best]
    return best if best.holds else _whole(best, pilots), left_out


def _rank(choice: _Choice) -> tuple[bool, float]:
    """The less the better: frames where the budget is held, what is nearest where it is not."""
    return not choice.holds, choice.cost.frame if choice.holds else choice.cost.most


def _beaten(other: _Choice) -> str:
    if other.holds:
        return f"{other.method} holds it too, with {1000 * other.cost.frame:.0f} ms a frame"
    return f"{other.method} is up to {_percent(other.cost.most)} off at best"


def _choose(method: str, pilots: Pilots, budget: float) -> _Choice:
    """Raise all settings together until the budget is held, then lower each as far as it is."""
    known = dict[str, Cost]()

    def cost_of(settings: dict[str, Any]) -> Cost:
        key = str(settings)
        if key not in known:
            known[key] = pilots.run(method, settings_at(method, settings))
        return known[key]

    settings, k = rung(method, 0), 0
    while cost_of(settings).most > budget and k + 1 < rungs(method):
        k += 1
        before, settings = cost_of(settings).most, rung(method, k)
        error, left = cost_of(settings).most, rungs(method) - 1 - k
        # At the rate of this rung, those that are left would not do.
        if error > budget and error * (error / before) ** left > budget:
            break
    if cost_of(settings).most > budget:
        # Nothing holds it: what is nearest, as cheap as it can be without being worse.
        best = min((rung(method, j) for j in range(k + 1)), key=lambda s: cost_of(s).most)
        reasons = [f"no setting comes below {_percent(cost_of(best).most)}"]
        return _Choice(method, best, cost_of(best), False, reasons)
    settings, reasons = _lowered(method, settings, cost_of, budget)
    return _Choice(method, settings, cost_of(settings), True, reasons)


def _whole(choice: _Choice, pilots: Pilots) -> _Choice:
    """The same, at what it costs in the whole picture."""
    settings = settings_at(choice.method, choice.settings)
    return replace(choice, cost=pilots.whole(choice.method, settings, choice.cost))


def _lowered(
    method: str,
    settings: dict[str, Any],
    cost_of: Callable[[dict[str, Any]], Cost],
    budget: float,
) -> tuple[dict[str, Any], list[str]]:
    """One setting after the other at the least that holds, and why it is not less."""
    reasons = []
    for name, steps in LADDERS[method].items():

        def error_of(k: int, chosen: dict[str, Any] = settings, name: str = name) -> float:
            return cost_of({**chosen, name: LADDERS[method][name][k]}).most

        least, before = _least(steps.index(settings[name]), error_of, budget)
        settings = {**settings, name: steps[least]}
        why = "the least is enough"
        if least:
            why = f"{steps[least - 1]} would be up to {_percent(before)} off"
        reasons.append(f"{name} = {steps[least]}: {why}")
    return settings, reasons


def _least(top: int, error_of: Callable[[int], float], bound: float) -> tuple[int, float]:
    """(the first step that holds where `top` does, the error of the one before), by halves."""
    error = error_of(0) if top else 0.0
    if error <= bound:
        return 0, 0.0
    before, least = 0, top
    while least - before > 1:
        middle = (before + least) // 2
        found = error_of(middle)
        if found <= bound:
            least = middle
        else:
            before, error = middle, found
    return least, error


def _percent(error: float) -> str:
    return f"{100 * error:.1f} %"
