"""Edits that no precompute has seen, and the pictures that they should give."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from engine.measure.edges import pixels_that_count
from engine.measure.held_out import drag_path
from engine.measure.metrics import Image, Mask, all_metrics, flicker, resolution
from engine.measure.truth import Truth, truth
from engine.methods.base import Progress
from engine.scene.edits import Edits, apply
from engine.scene.scene import Scene
from engine.store import Store

FLICKER = "flicker"  # a metric, beside those of `engine.measure.metrics`


@dataclass(frozen=True)
class Trial:
    """What every point of a chart has to show of a scene.

    edits   n of them
    truths  the reference of each; empty where only times are asked for
    kept    (h, w) bool of each, the pixels that count: no edges, no lamps themselves
    path    edits of a drag, one after the other, from the first of `edits`; may be empty
    along   the reference of each of those
    """

    scene: Scene
    edits: list[Edits]
    truths: list[Truth]
    kept: list[Mask]
    path: list[Edits]
    along: list[Truth]

    @property
    def floors(self) -> list[float]:
        """Per reference, the smallest error that its noise lets one see."""
        return [
            resolution(t.image, t.variance, kept)
            for t, kept in zip(self.truths, self.kept, strict=bool(self.truths))
        ]

    @property
    def own_change(self) -> float | None:
        """How much the truth changes from frame to frame of the drag, as `flicker` counts."""
        return self._flicker([0 * t.image for t in self.along]) if self.path else None

    def errors(self, images: Sequence[Image]) -> list[dict[str, float]]:
        """Every metric of the picture of every edit; none without truths."""
        return [
            all_metrics(image, t.image, kept, t.variance)
            for image, t, kept in zip(images, self.truths, self.kept, strict=bool(self.truths))
        ]

    def mean_error(
        self, errors: Sequence[dict[str, float]], dragged: Sequence[Image]
    ) -> dict[str, float]:
        """Means over the edits, and the flicker of the pictures of the path."""
        found = {name: float(np.mean([e[name] for e in errors])) for name in (errors or [{}])[0]}
        return {**found, FLICKER: self._flicker(dragged)} if self.path else found

    def _flicker(self, images: Sequence[Image]) -> float:
        return flicker(
            images, [t.image for t in self.along], self.kept[0], [t.variance for t in self.along]
        )


def trial_of(
    scene: Scene,
    edits: list[Edits],
    error: float,
    store: Store,
    progress: Progress,
    *,
    max_bounces: int | None = None,
    seed: int = 0,
    drag: bool = False,
) -> Trial:
    """References to a relative L2 error, from the store if it has them, and masks.

    seed  of their noise
    drag  whether there is a path too; its references have noise of their own each
    """
    path = drag_path(scene, edits[0]) if drag else []
    jobs = [(edit, seed) for edit in edits] + [(edit, seed + k + 1) for k, edit in enumerate(path)]
    found = []
    for number, (edit, own_seed) in enumerate(jobs):
        progress("references", number, len(jobs))
        found.append(truth(scene, edit, error, store, progress, own_seed, max_bounces))
    progress("references", len(jobs), len(jobs))
    return Trial(
        scene, edits, found[: len(edits)], masks_of(scene, edits), path, found[len(edits) :]
    )


def masks_of(scene: Scene, edits: Sequence[Edits]) -> list[Mask]:
    """Of the picture of every edit the pixels that count."""
    return [pixels_that_count(apply(scene, edit)) for edit in edits]
