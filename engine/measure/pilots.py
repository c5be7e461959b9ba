"""Small pictures that tell what large ones will be like: error, time and bytes of a setting.

A pilot is the whole method on few of the pixels, each as small as in the whole picture: a picture
of few large ones is mostly edges, which no error is taken over, and by an edge the error is larger
(in the knot, 6.6 % against 4.1). What one pilot has made others take up, so that each makes no more
than its own setting asks for. Where transport knows no camera a pilot is the precompute itself: it
stays in the user's store, and what is chosen need not be made again.

Direct light is interpolated between neighbours, which in few pixels lie too far apart. The methods
of a fixed view draw it in one way, which needs no precompute: it is taken from their pictures, and
from the references, and the error that it has by itself in a small whole picture is added. That
lies where shadows end within pixels, of which there are fewer the more pixels there are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.measure.fresh import fresh
from engine.measure.held_out import HELD_OUT
from engine.measure.metrics import Image, Mask
from engine.measure.sweep import STEP, time_frames
from engine.measure.trial import Trial, trial_of
from engine.measure.truth import Truth
from engine.methods import METHODS
from engine.methods.base import Progress
from engine.methods.fixed_view.view import View
from engine.scene.camera import Camera, sparse
from engine.scene.edits import apply, edited_camera
from engine.scene.scene import Scene
from engine.store import Store

SIDE = 64  # pixels along the longer side, about
LARGER = 3  # times as long: the second pilot of a setting
EDITS, SEED = 9, 101  # as many of each turn of `held_out_edits`
SURELY = 1.86  # standard deviations, estimated from nine edits, that are seldom exceeded: 1 in 20
REPEATS, MORE_REPEATS = 1, 5  # of timed frames: of every pilot, of the larger one
TIMED = 3  # edits of the larger one
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
    doubt       of the error: that of all pixels, over as many other edits, is seldom more above
    """

    error: float
    frame: float
    bytes: float
    precompute: float
    doubt: float = 0.0

    @property
    def most(self) -> float:
        """The error that other edits may well have."""
        return self.error + self.doubt


class Pilots:
    """Those of one scene, under edits that are drawn from a seed."""

    def __init__(
        self,
        scene: Scene,
        kinds: Sequence[str],
        noise: float,
        store: Store,
        progress: Progress,
        scratch: Store | None = None,
    ) -> None:
        """kinds are what is edited; references in `store` have a relative error of `noise`.

        References carry all light of the scene, so what a method leaves out counts as error. In
        `scratch` pilots lie that take up what others have made; without one each starts anew.
        """
        self._scene, self._store, self._scratch, self._progress = scene, store, scratch, progress
        few, small = _few(scene, SIDE), _sized(scene, SIDE)
        edits = [edit for kind in kinds for edit in HELD_OUT[kind](few, EDITS, SEED)]
        self._trial = trial_of(few, edits, noise, store, progress)
        lamps = [edit.model_copy(update={"environment": None}) for edit in edits]

        def lit(scene: Scene) -> Trial:
            # Noise of its own, or its variance would not add to that of all light.
            dark = scene.with_environment(None)
            return trial_of(dark, lamps, noise, store, progress, max_bounces=1, seed=1)

        apart, whole = lit(few), lit(small)
        shrunk = (_side(small.camera) / _side(scene.camera)) ** SHRINKS
        off = shrunk * _drawn_off(whole)
        self._direct = [_direct_of(apart, self._trial, k, off[k]) for k in range(len(edits))]
        # What some of the pixels do not tell of all of them.
        self._few = math.sqrt(1 - _pixels(few.camera) / _pixels(scene.camera))
        self.count = 0

    def run(self, method: str, settings: Any) -> Cost:
        """A picture of every edit, against its reference."""
        cost, images = self._run(self._trial, method, settings, REPEATS)
        apart = "lights" in METHODS[method].edits
        errors, unsure = [], []
        for k, (image, truth) in enumerate(zip(images, self._trial.truths, strict=True)):
            direct, kept = self._direct[k], self._trial.kept[k]
            own = direct.error if apart else 0.0
            if apart:
                image, truth = image - direct.image, direct.others
            off, more = _power(image - truth.image, truth.variance, kept)
            errors.append(math.sqrt(off / direct.power + own**2))
            more *= self._few
            unsure.append(math.sqrt((off + more) / direct.power + own**2) - errors[-1])
        among = math.sqrt(2 / len(errors)) * float(np.std(errors, ddof=1))
        doubt = SURELY * math.hypot(among, float(np.mean(unsure)))
        return replace(cost, error=float(np.mean(errors)), doubt=doubt)

    def lacking(self, method: str) -> float:
        """The error that a method has at least, whatever its settings: light that it leaves out."""
        if not METHODS[method].lamps_alone:
            return 0.0
        left = [
            _power(direct.others.image, direct.others.variance, kept)[0] / direct.power
            for direct, kept in zip(self._direct, self._trial.kept, strict=True)
        ]
        return float(np.mean(np.sqrt(left)))

    def whole(self, method: str, settings: Any, small: Cost) -> Cost:
        """For all pixels, from what a few more of them cost, each made from nothing."""
        larger = _few(self._scene, LARGER * SIDE)
        timed = self._trial.edits[:TIMED]
        seen, _ = self._run(
            Trial(larger, timed, [], [], [], []), method, settings, MORE_REPEATS, anew=True
        )
        if self._scratch is not None and not _without_camera(method):
            trial = replace(self._trial, edits=timed)
            again, _ = self._run(trial, method, settings, MORE_REPEATS, anew=True)
            small = replace(again, error=small.error, doubt=small.doubt)
        a, b, n = (_pixels(s.camera) for s in (self._trial.scene, larger, self._scene))

        def at_all(of_small: float, of_larger: float) -> float:
            if a == b:
                return of_larger
            return of_larger + max(0.0, of_larger - of_small) / (b - a) * (n - b)

        frame = at_all(small.frame, seen.frame)
        if _without_camera(method):
            return replace(small, frame=frame)
        return replace(
            small,
            frame=frame,
            bytes=at_all(small.bytes, seen.bytes),
            precompute=at_all(small.precompute, seen.precompute),
        )

    def _run(
        self, trial: Trial, method: str, settings: Any, repeats: int, anew: bool = False
    ) -> tuple[Cost, list[Image]]:
        """(its cost but for the error, the picture of every edit)."""
        self.count += 1
        kept = self._store if _without_camera(method) else None if anew else self._scratch
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
    error   what it is off in the whole picture, as a part of all light
    others  all other light, by references
    power   mean square of all light
    """

    image: Image
    error: float
    others: Truth
    power: float


def _direct_of(few: Trial, trial: Trial, k: int, off: float) -> _Direct:
    """Under edit k.

    few  has references of direct light, trial of all light
    off  how far it is off in the whole picture, as a part of itself
    """
    truth, every, kept = few.truths[k], trial.truths[k], trial.kept[k]
    variance = every.variance + truth.variance
    others = replace(every, image=every.image - truth.image, variance=variance)
    power = max(_power(every.image, every.variance, kept)[0], 1e-30)
    part = math.sqrt(_power(truth.image, truth.variance, kept)[0] / power)
    return _Direct(_drawn(few, k), off * part, others, power)


def _drawn_off(lit: Trial) -> NDArray[np.float64]:
    """(edits,): how far direct light is off in a picture of it, as a part of itself.

    As a part of what this picture shows, for where it has many edges it shows less than others.
    Where nothing of an edit's light is left it is taken to be off as that of other edits is.
    """
    found = np.zeros(len(lit.edits))
    for k, (truth, kept) in enumerate(zip(lit.truths, lit.kept, strict=True)):
        power, unsure = _power(truth.image, truth.variance, kept)
        off, _ = _power(_drawn(lit, k) - truth.image, truth.variance, kept)
        found[k] = math.sqrt(off / power) if power > unsure else np.nan
    known = found[~np.isnan(found)]
    return np.where(np.isnan(found), known.mean() if len(known) else 0.0, found)


def _drawn(lit: Trial, k: int) -> Image:
    scene = apply(lit.scene, lit.edits[k])
    return View(scene).direct(scene.lights, 1).reshape(lit.truths[k].image.shape)


def _power(image: Image, variance: Image, kept: Mask) -> tuple[float, float]:
    """(mean square over the pixels that count without that of the noise, its standard error)."""
    if not kept.any():
        return 0.0, 0.0
    squares = (image.astype(np.float64) ** 2 - variance)[kept].mean(axis=-1)
    return max(0.0, float(squares.mean())), float(squares.std() / math.sqrt(len(squares)))


def _few(scene: Scene, side: int) -> Scene:
    """The scene with about so many of its pixels along the longer side."""
    camera = scene.camera
    return scene.with_camera(sparse(camera, max(1, round(_side(camera) / side))))


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
