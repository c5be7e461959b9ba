"""What a sweep measured, and which of it is worth choosing."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from engine.measure.timing import Timing
from engine.measure.trial import Trial

MAIN_ERROR = "relative_l2"
# Knobs of points that belong to no setting: the defaults, a plan's, a step of a ladder.
DEFAULTS, PLAN, RUNG = "", "plan", "rung"


@dataclass(frozen=True)
class Point:
    """One setting of a method, measured.

    knob        the setting that was swept, or one of DEFAULTS, PLAN, RUNG
    error       mean over the edits of each metric of `engine.measure.metrics`, edges left out, and
                the flicker of a drag
    errors      the same per edit
    frame       seconds from light edit to linear frame, all edits, every part's median beside
    bytes       transport
    precompute  seconds
    """

    method: str
    knob: str
    settings: dict[str, Any]
    error: dict[str, float]
    errors: list[dict[str, float]]
    frame: Timing
    parts: dict[str, float]
    bytes: int
    precompute: float
    warnings: list[str]

    @property
    def label(self) -> str:
        """What the chart writes beside the point."""
        return f"{self.settings[self.knob]}" if self.knob else "defaults"


@dataclass(frozen=True)
class Sweep:
    """All points of a trial.

    points  settings of methods
    others  what one would do without a precompute
    """

    trial: Trial
    points: list[Point]
    others: list[Point]
    seed: int


COSTS: dict[str, Callable[[Point], float]] = {
    "frame_seconds": lambda point: point.frame.median,
    "bytes": lambda point: float(point.bytes),
    "precompute_seconds": lambda point: point.precompute,
}
"""What a small error may cost."""


def pareto_front(
    points: Sequence[Point], cost: str = "frame_seconds", metric: str = MAIN_ERROR
) -> list[int]:
    """Indices of the points that no other beats in both error and cost, the cheapest first."""
    price = COSTS[cost]
    order = sorted(range(len(points)), key=lambda k: (price(points[k]), points[k].error[metric]))
    front: list[int] = []
    for k in order:
        if not front or points[k].error[metric] < points[front[-1]].error[metric]:
            front.append(k)
    return front
