"""Small pictures that tell what large ones will be like: error, time and bytes of a setting.

A pilot is the whole method on a picture of few pixels. Where transport knows no camera it is the
precompute itself: it stays in the store, and what is chosen need not be made again.

The relative error of indirect light hardly depends on how many pixels there are. That of direct
light lies where shadows end within pixels, of which there are fewer the more pixels there are. The
methods of a fixed view draw direct light in one way, which needs no precompute: it is taken from
their pictures, and from the references, and the error that it has by itself is added as it shrinks.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from engine.measure.fresh import fresh
from engine.measure.held_out import HELD_OUT
from engine.measure.metrics import Image, Mask
from engine.measure.sweep import STEP, time_frames
from engine.measure.trial import Trial, trial_of
from engine.measure.truth import Truth
from engine.methods import METHODS
from engine.methods.base import Progress
from engine.methods.fixed_view.view import View
from engine.scene.camera import Camera
from engine.scene.edits import apply, edited_camera
from engine.scene.scene import Scene
from engine.store import Store

SIDE = 64  # pixels along the longer side
LARGER = 3  # times as long: the second pilot of a setting
EDITS, SEED = 6, 101
REPEATS, MORE_REPEATS = 1, 3  # of timed frames: of every pilot, of the larger one
# Error of direct light by the side of the picture: 15.8, 10.7, 5.8, 3.8 % of a spot in the Cornell
# box at 32, 64, 128, 256 pixels.
SHRINKS = 0.7


@dataclass(frozen=True)
class Cost:
    """What a setting gives and takes.

    error       relative L2 over the pixels that count, mean over the edits
    frame       seconds from edit to linear frame
    bytes       transport
    precompute  seconds
    """

    error: float
    frame: float
    bytes: float
    precompute: float


class Pilots:
    """Those of one scene, under edits that are drawn from a seed."""

    def __init__(
        self, scene: Scene, kinds: Sequence[str], noise: float, store: Store, progress: Progress
    ) -> None:
        """kinds are what is edited; references in `store` have a relative error of `noise`.

        References carry all light of the scene, so what a method leaves out counts as error.
        """
        self._scene, self._store, self._progress = scene, store, progress
        small = _sized(scene, SIDE)
        edits = [edit for kind in kinds for edit in HELD_OUT[kind](small, EDITS, SEED)]
        self._trial = trial_of(small, edits, noise, store, progress)
        lamps = [edit.model_copy(update={"environment": None}) for edit in edits]
        dark = small.with_environment(None)
        # Noise of its own, or its variance would not add to that of all light.
        lit = trial_of(dark, lamps, noise, store, progress, max_bounces=1, seed=1)
        self._direct = [_direct_of(lit, self._trial, k) for k in range(len(edits))]
        self.count = 0

    def run(self, method: str, settings: Any) -> Cost:
        """A small picture of every edit, against its reference; the error is of a whole one."""
        cost, images = self._run(self._trial, method, settings, REPEATS)
        shrunk = (SIDE / max(SIDE, _side(self._scene.camera))) ** SHRINKS
        apart = "lights" in METHODS[method].edits
        errors = []
        for k, (image, truth) in enumerate(zip(images, self._trial.truths, strict=True)):
            direct, kept = self._direct[k], self._trial.kept[k]
            own = shrunk * direct.error if apart else 0.0
            if apart:
                image, truth = image - direct.image, direct.others
            off = _power(image - truth.image, truth.variance, kept)
            errors.append(math.sqrt(off / direct.power + own**2))
        return replace(cost, error=float(np.mean(errors)))

    def whole(self, method: str, settings: Any, small: Cost) -> Cost:
        """For all pixels, from what a few more of them cost."""
        larger = _sized(self._scene, LARGER * SIDE)
        trial = Trial(larger, self._trial.edits, [], [], [], [])
        seen, _ = self._run(trial, method, settings, MORE_REPEATS)
        a, b, n = (_pixels(s.camera) for s in (self._trial.scene, larger, self._scene))

        def at_all(of_small: float, of_larger: float) -> float:
            if a == b:
                return of_larger
            return of_larger + max(0.0, of_larger - of_small) / (b - a) * (n - b)

        frame = at_all(small.frame, seen.frame)
        if _without_camera(method):
            return replace(small, frame=frame)
        return Cost(
            small.error,
            frame,
            at_all(small.bytes, seen.bytes),
            at_all(small.precompute, seen.precompute),
        )

    def _run(
        self, trial: Trial, method: str, settings: Any, repeats: int
    ) -> tuple[Cost, list[Image]]:
        """(its cost but for the error, the picture of every edit)."""
        self.count += 1
        kept = self._store if _without_camera(method) else None
        with fresh(trial.scene, method, settings, self._progress, store=kept) as made:
            step = STEP * trial.scene.diagonal
            frames, timing, _ = time_frames(made.product, trial.edits, repeats, step)
            cost = Cost(0.0, timing.median, made.product.bytes, made.seconds)
        return cost, [frame.image for frame in frames]


def _without_camera(method: str) -> bool:
    """Whether a precompute is the same for pictures of any size."""
    return "camera" in METHODS[method].edits


@dataclass(frozen=True)
class _Direct:
    """The direct light of lamps under an edit.

    image   as methods of a fixed view draw it
    error   what it is off, as a part of all light
    others  all other light, by references
    power   sum of squares of all light
    """

    image: Image
    error: float
    others: Truth
    power: float


def _direct_of(lit: Trial, trial: Trial, k: int) -> _Direct:
    """Under edit k, which `lit` has references of direct light of, and `trial` of all light."""
    scene, truth, every, kept = (
        apply(lit.scene, lit.edits[k]), lit.truths[k], trial.truths[k], trial.kept[k]
    )  # fmt: skip
    image = View(scene).direct(scene.lights, 1).reshape(truth.image.shape)
    power = max(_power(every.image, every.variance, kept), 1e-30)
    off = _power(image - truth.image, truth.variance, kept)
    variance = every.variance + truth.variance
    others = replace(every, image=every.image - truth.image, variance=variance)
    return _Direct(image, math.sqrt(off / power), others, power)


def _power(image: Image, variance: Image, kept: Mask) -> float:
    """Sum of squares over the pixels that count, without that of the noise."""
    return max(0.0, float(((image.astype(np.float64) ** 2 - variance)[kept]).sum()))


def _sized(scene: Scene, side: int) -> Scene:
    """The scene with so many pixels along its longer side, and no more than it has."""
    camera = scene.camera
    part = min(1.0, side / _side(camera))
    size = {n: max(1, round(part * getattr(camera, n))) for n in ("width", "height")}
    return scene.with_camera(edited_camera(camera, size))


def _side(camera: Camera) -> int:
    return max(camera.width, camera.height)


def _pixels(camera: Camera) -> int:
    return camera.width * camera.height
