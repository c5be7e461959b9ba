"""What a sweep measured, and which of it is worth choosing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from engine.measure.timing import Timing
from engine.measure.truth import Truth
from engine.scene.edits import Edits
from engine.scene.scene import Scene

MAIN_ERROR = "relative_l2"


@dataclass(frozen=True)
class Point:
    """One setting of a method, measured.

    knob        the setting that was swept; empty for the defaults
    error       mean over the edits of each metric of `engine.measure.metrics`, edges left out
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
    """All points of a scene.

    edits       the light edits that they were judged on
    truths      the reference of each
    floors      per reference, the smallest error that its noise lets one see
    edge_share  of the pixels, left out
    """

    scene: Scene
    edits: list[Edits]
    truths: list[Truth]
    floors: list[float]
    edge_share: float
    points: list[Point]
    seed: int


def pareto_front(points: Sequence[Point], metric: str = MAIN_ERROR) -> list[int]:
    """Indices of the points that no other point beats in both error and frame time, by time."""
    order = sorted(
        range(len(points)), key=lambda k: (points[k].frame.median, points[k].error[metric])
    )
    front: list[int] = []
    for k in order:
        if not front or points[k].error[metric] < points[front[-1]].error[metric]:
            front.append(k)
    return front
