"""Speed against accuracy: every setting of a method swept, frame time and error recorded.

Settings are swept one at a time from the method's defaults, so that each line of the chart tells
what one of them buys. Every point is a fresh precompute, judged on light edits that it has not
seen against references of the path tracer, which the store keeps.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from engine.errors import InputError, NotFound
from engine.measure.edges import scene_edges
from engine.measure.fresh import fresh
from engine.measure.material_edits import held_out_materials
from engine.measure.metrics import all_metrics, resolution
from engine.measure.points import Point, Sweep
from engine.measure.probes import held_out_edits, held_out_turns, nudged
from engine.measure.settings import settings_from
from engine.measure.timing import Timing
from engine.measure.truth import Truth, truth
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

JUDGED_ON = "materials", "lights", "environment"
DIRECT = {"wavelet_brdf"}  # methods whose light is reflected once; they are judged on moved lights
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
    fixed: Mapping[str, Any] | None = None,
    knobs: Mapping[str, Sequence[Any]] | None = None,
    edits: int = 4,
    seed: int = 1,
    reference_error: float = REFERENCE_ERROR,
    store: Store | None = None,
    progress: Progress = silent,
) -> Sweep:
    """Measure every variant of every method on a scene.

    fixed            settings that hold for every point
    knobs            what to sweep in place of SWEEPS
    edits            how many light edits to judge on
    reference_error  relative L2 error that the references are rendered to
    store            where references are kept
    """
    todo = [(m, knob, s) for m in methods for knob, s in variants(m, fixed or {}, knobs)]
    scene, held_out = judged_on(scene, methods, edits, seed)
    truths = []
    for number, edit in enumerate(held_out):
        progress("references", number, edits)
        args = (scene, edit, reference_error, store or Store(), progress)
        truths.append(truth(*args, max_bounces=1 if set(methods) <= DIRECT else None))
    progress("references", edits, edits)
    kept = ~scene_edges(scene)
    floor = [resolution(t.image, t.variance, kept) for t in truths]

    points = []
    for number, (method, knob, settings) in enumerate(todo):
        progress("settings", number, len(todo))
        points.append(measure(scene, method, knob, settings, held_out, truths, kept, progress))
    progress("settings", len(todo), len(todo))
    return Sweep(scene, held_out, truths, floor, float(1.0 - kept.mean()), points, seed)


def judged_on(
    scene: Scene, methods: Sequence[str], count: int, seed: int
) -> tuple[Scene, list[Edits]]:
    """(scene, edits) that methods are judged on: of lights, of materials, or turns of the sky.

    A method that carries no lights is judged without the scene's own.
    """
    taken = {
        next(key for key in JUDGED_ON[method in DIRECT :] if key in METHODS[method].edits)
        for method in methods
    }
    if len(taken) > 1:
        raise InputError(
            f"{', '.join(methods)} take different edits: chart them one by one", field="method"
        )
    if taken == {"lights"}:
        return scene, held_out_edits(scene, count, seed)
    if taken == {"materials"}:
        return scene, held_out_materials(scene, count, seed)
    return scene.with_lights(()), held_out_turns(scene, count, seed)


def measure(
    scene: Scene,
    method: str,
    knob: str,
    settings: Any,
    edits: list[Edits],
    truths: list[Truth],
    kept: np.ndarray,
    progress: Progress,
    views: Sequence[Edits] = (),
) -> Point:
    """A fresh precompute: its time and size, and its frames of the edits against their truths.

    kept (h, w) bool are the pixels that count. Without truths there are no errors. Of frames of
    which each has another one of the views, the median time is added to the parts.
    """
    with fresh(scene, method, settings, progress) as made:
        frames, timing, parts = time_frames(made.product, edits, REPEATS, STEP * scene.diagonal)
        errors = [
            all_metrics(frame.image, truth.image, kept, truth.variance)
            for frame, truth in zip(frames, truths, strict=bool(truths))
        ]
        if views:
            _, viewing, _ = time_frames(made.product, views, REPEATS, STEP * scene.diagonal)
            parts[NEW_VIEW] = viewing.median
        return Point(
            method=method,
            knob=knob,
            settings=dataclasses.asdict(settings),
            error={
                name: float(np.mean([e[name] for e in errors]))
                for name in (errors[0] if errors else ())
            },
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
    of its repetitions. The times are in the order of the repetitions, edit by edit in each.
    """
    every = range(len(edits))
    together = [[k] for k in every] if any(edit.materials for edit in edits) else [every]
    frames: list[Frame] = []
    timed: list[Frame] = []
    seconds = np.zeros((repeats, len(edits)))
    for group in together:
        frames += [product.relight(edits[k]) for k in group]
        for turn in range(repeats):
            for k in group:
                moved = nudged(edits[k], (turn + 1) * step)
                start = time.perf_counter()
                timed.append(product.relight(moved))
                seconds[turn, k] = time.perf_counter() - start
    return frames, Timing(tuple(seconds.ravel())), median_parts(timed)


def median_parts(frames: Sequence[Frame]) -> dict[str, float]:
    """Median seconds of every part that the frames report."""
    names = dict.fromkeys(name for frame in frames for name in frame.timings)
    return {
        name: float(np.median([frame.timings.get(name, 0.0) for frame in frames])) for name in names
    }
