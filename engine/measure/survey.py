"""What edits of a scene cost under every method, and whether the planner's choice was the best.

Every rung of every ladder is precomputed and measured whole, and so is the plan. All light of the
scene shines, as its user sees it: what a method does not carry counts as error.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from engine.errors import SceneError
from engine.measure.document import sweep_document
from engine.measure.held_out import HELD_OUT
from engine.measure.ladders import rung, rungs, settings_at
from engine.measure.machine import this_machine
from engine.measure.others import others
from engine.measure.planner import NOISE, Plan
from engine.measure.points import MAIN_ERROR, PLAN, RUNG, Point, Sweep
from engine.measure.sweep import measure
from engine.measure.trial import Trial, trial_of
from engine.methods import METHODS
from engine.methods.base import Progress, silent
from engine.scene.scene import Scene
from engine.store import Store

EDITS, SEED = 6, 1  # of every kind, as many of each turn: others than the planner draws
REPEATS = 3  # of every edit's frame, timed
STALLED = 0.9  # of the error that the rung before had
LONGEST, SLOWEST = 20.0, 0.5  # seconds of a precompute and of a frame, beyond which nobody waits


def kinds_of(scene: Scene) -> list[tuple[str, ...]]:
    """What one would edit in a scene: that of which it has any, each alone.

    The camera where no lamps shine, which no method carries together with indirect light for it.
    """
    found: list[tuple[str, ...]] = []
    if scene.lights:
        found.append(("lights",))
    if scene.environment is not None:
        found.append(("environment",))
        if not scene.lights:
            found.append(("camera",))
    try:
        HELD_OUT["materials"](scene, 1, SEED)
    except SceneError:
        return found
    return [*found, ("materials",)]


def survey(
    scene: Scene,
    planned: Plan,
    *,
    rivals: bool = False,
    store: Store | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """A document as that of a sweep, with a plan of the scene and how it came out.

    rivals  whether Mitsuba 3 is among the others
    """
    kinds = planned.edits
    edits = [edit for kind in kinds for edit in HELD_OUT[kind](scene, EDITS, SEED)]
    noise = NOISE * planned.budget
    trial = trial_of(scene, edits, noise, store or Store(), progress)
    chosen = _measured(trial, planned.method, PLAN, planned.settings, progress)
    points = [chosen]
    able = [name for name, method in METHODS.items() if set(kinds) <= method.edits]
    for number, method in enumerate(able):
        progress("methods", number, len(able))
        points += _climbed(trial, method, progress)
    progress("methods", len(able), len(able))
    rest = others(trial, None, rivals, progress)
    document = sweep_document(Sweep(trial, points, rest, SEED), this_machine())
    return {**document, "kinds": list(kinds), "plan": _kept(planned, chosen, points[1:])}


def _climbed(trial: Trial, method: str, progress: Progress) -> Iterator[Point]:
    """The rungs of a method, until one mends nothing or takes too long."""
    before = float("inf")
    for k in range(rungs(method)):
        point = _measured(trial, method, RUNG, settings_at(method, rung(method, k)), progress)
        yield replace(point, settings={RUNG: k, **point.settings})
        error = point.error[MAIN_ERROR]
        too_long = point.precompute > LONGEST or point.frame.median > SLOWEST
        if too_long or error > STALLED * before:
            return
        before = error


def _measured(trial: Trial, method: str, knob: str, settings: Any, progress: Progress) -> Point:
    return measure(trial, method, knob, settings, progress, repeats=REPEATS)


def _kept(planned: Plan, chosen: Point, swept: Sequence[Point]) -> dict[str, Any]:
    """The plan as JSON, what it came to, and the fastest swept setting that holds the budget."""
    holding = [p for p in swept if p.error[MAIN_ERROR] <= planned.budget]
    best = min((p.frame.median for p in holding), default=None)
    return {
        **planned.as_dict(),
        "measured": {
            "error": chosen.error[MAIN_ERROR],
            "frame": chosen.frame.median,
            "bytes": chosen.bytes,
            "precompute": chosen.precompute,
        },
        "kept": chosen.error[MAIN_ERROR] <= planned.budget,
        "best_swept_frame": best,
    }
