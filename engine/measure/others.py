"""What one would do without a precompute: render the edited scene anew, with n samples a pixel.

The engine's own path tracer always; Mitsuba 3, alone and denoised, where that is asked for. Each
point is a picture of so many samples, timed as it is: samples are multiplied by four until a
picture takes too long for anybody to wait for.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from engine.measure.metrics import Image
from engine.measure.points import Point
from engine.measure.timing import Timing
from engine.measure.trial import Trial
from engine.measure.truth import Truth
from engine.methods.base import Progress
from engine.reference import render
from engine.scene.edits import Edits, apply

PATH_TRACER, MITSUBA, DENOISED = "path tracer", "Mitsuba 3", "Mitsuba 3, denoised"
SAMPLES = "samples"  # what is swept
MOST_SAMPLES, FACTOR = 1024, 4
LONGEST = 4.0  # seconds that a picture may take
SEED = 1000  # of pictures: references have small ones
REFERENCE_SAMPLES = 256  # of each of two pictures by Mitsuba that its own are judged by

Draw = Callable[[Edits, int, int], Image]
"""(edit, samples, seed) -> picture."""


def others(trial: Trial, bounces: int | None, rivals: bool, progress: Progress) -> list[Point]:
    """All points; `bounces` is what light is cut off after, None where it is not."""

    def trace(edit: Edits, samples: int, seed: int) -> Image:
        edited = apply(trial.scene, edit)
        return render(edited, samples=samples, seed=seed, max_bounces=bounces).image

    points = list(_points(PATH_TRACER, trace, trial, progress))
    if rivals:
        points += _mitsuba(trial, bounces, progress)
    return points


def _points(name: str, draw: Draw, trial: Trial, progress: Progress) -> Iterator[Point]:
    """Points of more and more samples."""
    draw(trial.edits[0], 1, SEED)  # compiles
    samples = 1
    while samples <= MOST_SAMPLES:
        progress(name, np.log2(samples), np.log2(MOST_SAMPLES))
        seconds, images = [], []
        for number, edit in enumerate(trial.edits):
            start = time.perf_counter()
            images.append(draw(edit, samples, SEED + number))
            seconds.append(time.perf_counter() - start)
        dragged = [draw(edit, samples, 2 * SEED + k) for k, edit in enumerate(trial.path)]
        errors, frame = trial.errors(images), Timing(tuple(seconds))
        error = trial.mean_error(errors, dragged)
        yield Point(name, SAMPLES, {SAMPLES: samples}, error, errors, frame, {}, 0, 0.0, [])
        if frame.median > LONGEST / FACTOR:
            break
        samples *= FACTOR
    progress(name, 1, 1)


def _mitsuba(trial: Trial, bounces: int | None, progress: Progress) -> Iterator[Point]:
    """Judged by converged pictures of its own kind: see `engine.measure.mitsuba_scene`."""
    from engine.measure.mitsuba_renderer import Mitsuba, take_fastest

    take_fastest()
    ready: dict[str, Mitsuba] = {}

    def of(edit: Edits) -> Mitsuba:
        key = edit.model_dump_json()
        if key not in ready:
            ready[key] = Mitsuba(apply(trial.scene, edit), bounces)
        return ready[key]

    def converged(edit: Edits) -> Truth:
        a, b = (of(edit).picture(REFERENCE_SAMPLES, seed) for seed in (1, 2))
        half = np.float32(0.5)
        return Truth(half * (a + b), (half * (a - b)) ** 2, 0.0, 0.0, 2 * REFERENCE_SAMPLES)

    judged = replace(
        trial,
        truths=[converged(edit) for edit in trial.edits],
        along=[converged(edit) for edit in trial.path],
    )
    # One that runs when the picture is asked for, not when the clock does.
    for edit in (*trial.edits, *trial.path):
        of(edit)
    yield from _points(MITSUBA, lambda e, n, seed: of(e).picture(n, seed), judged, progress)
    yield from _points(
        DENOISED, lambda e, n, seed: of(e).denoised(n, seed, "Balanced"), judged, progress
    )
