"""Speed against accuracy: every setting of a method swept, frame time and error recorded.

Settings are swept one at a time from the method's defaults, so that each line of the chart tells
what one of them buys. Every point is a fresh precompute, judged on light edits that it has not
seen against references of the path tracer, which the store keeps.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np

from engine.errors import NotFound
from engine.measure.fresh import fresh
from engine.measure.held_out import judged_on
from engine.measure.others import others
from engine.measure.points import Point, Sweep
from engine.measure.probes import nudged
from engine.measure.settings import settings_from
from engine.measure.timing import Timing
from engine.measure.trial import Trial, trial_of
from engine.methods import METHODS
from engine.methods.base import Frame, Product, Progress, silent
from engine.scene.edits import Edits
from engine.scene.scene import Scene
from engine.store import Store

SWEEPS: dict[str, dict[str, tuple[Any, ...]]] = {
    "direct_to_indirect": {
        "coefficients": (25, 50, 100, 200, 400),
        "bounce_coefficients": (20, 40, 80, 160),
        "gather_samples": (4096, 16384, 65536, 262144),
        "cloud": ("uniform", "importance"),
        "gather": ("rays", "links"),
        "view_rays": (89, 233, 610, 1597),
        "bounces": (0, 1, 2, 3, 5),
    },
    "glossy_prt": {
        "terms": (1, 2, 4, 8, 16),
        "coefficients": (32, 64, 128, 256, 512),
        "cluster_error": (0.2, 0.1, 0.05, 0.02, 0.01),
        "light_texels": (16, 32, 64),
        "bounces": (0, 1, 2),
        "bounce_coefficients": (24, 48, 96),
        "gather_texels": (8, 16, 32),
    },
    "brdf_editing": {
        "bands": (8, 16, 32, 64, 128),
        "basis": ("tents", "boxes"),
        "bounces": (0, 1, 2, 3, 5),
        "view_rays": (64, 128, 256, 512, 1024),
        "lobe_rays": (0.0, 0.15, 0.3, 0.5),
        "gather_samples": (1024, 4096, 16384, 65536),
    },
    "wavelet_brdf": {
        "cells": (8, 16, 32, 64),
        "error": (0.001, 0.003, 0.01, 0.03, 0.1),
        "level": (0.0, 1.0, 2.0, 3.0, 4.0),
        "filter": ("bilinear", "nearest"),
        "detail": ("distance", "footprint", "finest"),
    },
}
"""Per method: the settings to sweep and their values."""

REPEATS = 9
NEW_VIEW = "new view"  # a part of `Point.parts`
STEP = 1e-3  # of the scene's size
REFERENCE_ERROR = 0.05  # the noise is taken out again, see `engine.measure.metrics.relative_l2`


def variants(
    method: str, fixed: Mapping[str, Any], knobs: Mapping[str, Sequence[Any]] | None = None
) -> list[tuple[str, Any]]:
    """(swept setting, settings) of every point; the defaults first, no settings twice."""
    if method not in METHODS:
        raise NotFound(f"there is no method {method!r}; there are {', '.join(METHODS)}")
    kind = METHODS[method].settings
    base = settings_from(kind, fixed)
    found: list[tuple[str, Any]] = [("", base)]
    for knob, values in (SWEEPS.get(method, {}) if knobs is None else knobs).items():
        for value in values:
            settings = settings_from(kind, {**fixed, **along(method, knob, value), knob: value})
            if settings not in [other for _, other in found]:
                found.append((knob, settings))
    return found


def _known_to(method: str, methods: Sequence[str], chosen: Mapping[str, Any]) -> dict[str, Any]:
    """Of chosen settings those that a method has; all of them where no other of `methods` does."""
    kinds = {
        m: [f.name for f in dataclasses.fields(METHODS[m].settings)]
        for m in methods
        if m in METHODS
    }
    return {
        name: value
        for name, value in chosen.items()
        if name in kinds.get(method, ()) or not any(name in names for names in kinds.values())
    }


def along(method: str, knob: str, value: Any) -> dict[str, Any]:
    """Settings that go with a value of another; wavelets are counted where clusters are not."""
    if method == "glossy_prt" and knob == "light_texels":
        return {"visibility_texels": 2 * value}
    if method == "glossy_prt" and knob in ("coefficients", "bounce_coefficients"):
        return {"cluster_error": 0.0}
    return {}


def sweep(
    scene: Scene,
    methods: Sequence[str],
    *,
    of: str | None = None,
    fixed: Mapping[str, Any] | None = None,
    knobs: Mapping[str, Sequence[Any]] | None = None,
    edits: int = 4,
    seed: int = 1,
    reference_error: float = REFERENCE_ERROR,
    rivals: bool = False,
    store: Store | None = None,
    progress: Progress = silent,
) -> Sweep:
    """Measure every variant of every method on a scene, and what one would do without them.

    of               what is edited; see `engine.measure.held_out.kind_of_edits`
    fixed            settings that hold for every point
    knobs            what to sweep in place of SWEEPS
    edits            how many edits to judge on
    reference_error  relative L2 error that the references are rendered to
    rivals           whether Mitsuba 3 is among the others
    store            where references are kept
    """
    if rivals:
        import_module("engine.measure.mitsuba_renderer")  # says what is missing before the work
    todo = [
        (method, knob, settings)
        for method in methods
        for knob, settings in variants(
            method,
            _known_to(method, methods, fixed or {}),
            None if knobs is None else _known_to(method, methods, knobs),
        )
    ]
    scene, held_out = judged_on(scene, methods, edits, seed, of)
    # Where nobody carries what is reflected twice, it is not asked for.
    bounces = 1 if all(METHODS[m].lamps_alone for m in methods) else None
    trial = trial_of(
        scene, held_out, reference_error, store or Store(), progress,
        max_bounces=bounces, drag=True,
    )  # fmt: skip
    points = []
    for number, (method, knob, settings) in enumerate(todo):
        progress("settings", number, len(todo))
        points.append(measure(trial, method, knob, settings, progress))
    progress("settings", len(todo), len(todo))
    return Sweep(trial, points, others(trial, bounces, rivals, progress), seed)


def measure(
    trial: Trial,
    method: str,
    knob: str,
    settings: Any,
    progress: Progress,
    views: Sequence[Edits] = (),
    repeats: int = REPEATS,
) -> Point:
    """A fresh precompute: its time and size, and its frames of the trial against their truths.

    repeats  of every edit's frame, timed
    views    of frames of which each has another one of these, the median time is added to the parts
    """
    step = STEP * trial.scene.diagonal
    with fresh(trial.scene, method, settings, progress) as made:
        frames, timing, parts = time_frames(made.product, trial.edits, repeats, step)
        errors = trial.errors([frame.image for frame in frames])
        dragged = [made.product.relight(edit).image for edit in trial.path]
        if views:
            _, viewing, _ = time_frames(made.product, views, repeats, step)
            parts[NEW_VIEW] = viewing.median
        return Point(
            method=method,
            knob=knob,
            settings=dataclasses.asdict(settings),
            error=trial.mean_error(errors, dragged),
            errors=errors,
            frame=timing,
            parts=parts,
            bytes=made.product.bytes,
            precompute=made.seconds,
            warnings=sorted({w.message for frame in frames for w in frame.warnings}),
        )


def time_frames(
    product: Product, edits: Sequence[Edits], repeats: int, step: float
) -> tuple[list[Frame], Timing, dict[str, float]]:
    """(frame of every edit, time of all repetitions, median seconds of their parts).

    Every repetition moves the edit's lights on by `step` metres, as a hand does: the product has
    not seen any of them, and can repeat nothing that it remembers. A material stays in hand for all
    of its edits and their repetitions. The times are in the order of the repetitions, edit by edit
    in each.
    """
    every = range(len(edits))
    together: list[Sequence[int]] = [every]
    if any(edit.materials for edit in edits):
        together = [[k] for k in sorted(every, key=lambda k: list(edits[k].materials or ()))]
    frames: dict[int, Frame] = {}
    timed: list[Frame] = []
    seconds = np.zeros((repeats, len(edits)))
    for group in together:
        frames |= {k: product.relight(edits[k]) for k in group}
        for turn in range(repeats):
            for k in group:
                moved = nudged(edits[k], (turn + 1) * step)
                start = time.perf_counter()
                timed.append(product.relight(moved))
                seconds[turn, k] = time.perf_counter() - start
    return [frames[k] for k in every], Timing(tuple(seconds.ravel())), median_parts(timed)


def median_parts(frames: Sequence[Frame]) -> dict[str, float]:
    """Median seconds of every part that the frames report."""
    names = dict.fromkeys(name for frame in frames for name in frame.timings)
    return {
        name: float(np.median([frame.timings.get(name, 0.0) for frame in frames])) for name in names
    }
