"""Timings of this machine, beside what it could do at best and what brute force would cost."""

from __future__ import annotations

import dataclasses
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from engine.measure.document import finite, provenance
from engine.measure.machine import this_machine
from engine.measure.probes import held_out_edits
from engine.measure.settings import settings_from
from engine.measure.sweep import STEP, time_frames
from engine.measure.timing import PhaseClock, stopwatch
from engine.methods import METHODS, prepare
from engine.methods.base import Progress, silent
from engine.reference import render
from engine.scene.edits import Edits, apply
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.store import Store

SCENES = ("cornell-box", "room")
METHOD = "direct_to_indirect"
EDITS, REPEATS = 6, 5
REFERENCE_SAMPLES, REFERENCE_ERROR = 16, 0.02


def bench(
    sources: Sequence[str] = SCENES,
    progress: Progress = silent,
    changes: Mapping[str, Any] | None = None,
) -> dict[str, Any]:
    """Precompute and frame times of every scene at the method's defaults, as JSON.

    `changes` replaces some of the defaults.

    Transport is made from nothing, in a store that is thrown away.
    """
    machine = this_machine()
    bandwidth = machine.memory_read_gb_s * 1e9
    settings = settings_from(METHODS[METHOD].settings, changes or {})
    scenes = [_bench_scene(open_scene(source), settings, bandwidth, progress) for source in sources]
    return finite({**provenance(), "machine": machine.as_dict(), "scenes": scenes})


def _bench_scene(
    scene: Scene, settings: Any, bandwidth: float, progress: Progress
) -> dict[str, Any]:
    edits = held_out_edits(scene, EDITS, seed=1)
    with tempfile.TemporaryDirectory(prefix="relight-bench-") as folder:
        clock = PhaseClock(progress)
        product: Any = None

        def make() -> None:
            nonlocal product
            product = prepare(scene, METHOD, settings, store=Store(Path(folder)), progress=clock)

        precompute = stopwatch(make)
        clock.stop()
        _, timing, parts = time_frames(product, edits, REPEATS, STEP * scene.diagonal)

    # Brute force gets the same job, the first of the edits. Its error falls as 1/√samples, so a
    # few samples tell how long it would take to an error that can be looked at.
    result = render(apply(scene, edits[0]), samples=REFERENCE_SAMPLES, progress=progress)
    brute_force = result.seconds * (result.error / REFERENCE_ERROR) ** 2
    camera = scene.camera
    return {
        "scene": scene.name,
        "width": camera.width,
        "height": camera.height,
        "triangles": len(scene.geometry.triangles),
        "method": METHOD,
        "settings": dataclasses.asdict(settings),
        "precompute_seconds": precompute,
        "phase_seconds": clock.seconds,
        "bytes": product.bytes,
        "frame_seconds": {
            "median": timing.median,
            "p95": timing.p95,
            "parts": parts,
            "lights": _by_light(edits, timing.seconds),
        },
        "reference": {
            "samples": result.samples,
            "seconds": result.seconds,
            "error": result.error,
            "seconds_to_2_percent": brute_force,
        },
        "ratios": {
            "memory_bandwidth_used": product.bytes / timing.median / bandwidth,
            "reference_over_frame": brute_force / timing.median,
            "precompute_over_reference": precompute / brute_force,
        },
    }


def _by_light(edits: Sequence[Edits], seconds: Sequence[float]) -> dict[str, float]:
    """Median seconds by what each edit moves: one of the scene's lights, or a new one of a type."""
    times: dict[str, list[float]] = {}
    for turn, took in enumerate(seconds):
        light = (edits[turn % len(edits)].lights or [{}])[-1]
        name = f"a new {light['type']} light" if "type" in light else f"{light['id']!r} moved"
        times.setdefault(name, []).append(took)
    return {name: float(np.median(took)) for name, took in times.items()}
