"""Frames beside what the reference shows of the same edits.

The frame is drawn when somebody asks. The reference is a job in a process of its own, which leaves
it in the store; once it is there the two are compared.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from engine.errors import NotFound
from engine.measure.edges import pixels_that_count
from engine.measure.false_colour import Difference, difference
from engine.measure.truth import Truth, known_truth
from engine.measure.verdict import verdict
from engine.numerics.display import to_srgb8
from engine.scene.edits import apply
from engine.scene.scene import Scene
from engine.store import Store
from server.precompute import Task
from server.wire import ReferenceResult, Shown

KEPT = 8  # that can still be asked for
MOST_PIXELS = 1 << 22  # of a reference


@dataclass(frozen=True)
class Compared:
    """A frame, (h, w, 3) float32 linear radiance, the method that drew it, and its reference."""

    scene: Scene
    task: Task
    frame: NDArray[np.float32]
    method: str

    @cached_property
    def truth(self) -> Truth:
        """Raises NotFound while it is not there."""
        task = self.task
        found = known_truth(self.scene, task.edits, task.error, Store(), task.seconds)
        if found is None:
            raise NotFound("the reference is not there yet")
        return found

    @cached_property
    def kept(self) -> NDArray[np.bool_]:
        """(h, w): the pixels that count."""
        return pixels_that_count(apply(self.scene, self.task.edits))

    @cached_property
    def difference(self) -> Difference:
        """In false colour."""
        return difference(self.frame, self.truth, self.kept)

    def result(self, exposure: float) -> ReferenceResult:
        """The numbers, at an exposure in stops."""
        return ReferenceResult(
            method=self.method,
            verdict=verdict(self.frame, self.truth, self.kept, exposure),
            samples=self.truth.samples,
            seconds=round(self.truth.seconds, 2),
            full=self.difference.full,
            averaged=self.difference.averaged,
        )

    def picture(self, which: Shown, exposure: float) -> NDArray[np.uint8]:
        """(h, w, 3) sRGB; the difference is the same at any exposure."""
        if which == "difference":
            return np.round(255 * self.difference.colours).astype(np.uint8)
        return to_srgb8(self.frame if which == "live" else self.truth.image, exposure)
