"""Timings of this machine, beside what it could do at best and what brute force would cost."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from engine.backend.cpu.product import multiply
from engine.measure import bench_codes
from engine.measure.backends import by_backend, require_gl
from engine.measure.document import finite, provenance
from engine.measure.fresh import fresh
from engine.measure.held_out import judged_on
from engine.measure.machine import this_machine
from engine.measure.material_edits import held_out_materials
from engine.measure.probes import held_out_edits, held_out_views
from engine.measure.settings import settings_from
from engine.measure.sweep import STEP, time_frames
from engine.measure.timing import repeat
from engine.methods import METHODS
from engine.methods.base import Progress, silent
from engine.methods.brdf_editing import Polynomial
from engine.methods.direct_to_indirect import Transfer
from engine.methods.fixed_view.tiles import pixel_tiles, run_tiles
from engine.methods.glossy_prt import Prt
from engine.methods.wavelet_brdf import Wavelets
from engine.reference import render
from engine.scene.edits import Edits, apply
from engine.scene.scene import Scene

SCENES = ("cornell-box", "room")
METHOD = "direct_to_indirect"
EDITS, REPEATS = 6, 5
RIVAL_EDITS = 3  # one of each kind
PRODUCTS = 15
REFERENCE_SAMPLES, REFERENCE_ERROR = 16, 0.02


def bench(
    scenes: Sequence[Scene],
    progress: Progress = silent,
    changes: Mapping[str, Any] | None = None,
    *,
    method: str = METHOD,
    against_rivals: bool = False,
    with_gl: bool = False,
) -> dict[str, Any]:
    """Precompute and frame times of every scene at the method's defaults, as JSON.

    `changes` replaces some of the defaults. `against_rivals` adds what `engine.measure.rivals`
    finds, which needs the packages of the extra `peers`; `with_gl` what `engine.measure.backends`
    finds, which needs OpenGL.

    Transport is made from nothing, in a store that is thrown away.
    """
    if against_rivals:
        import engine.measure.rivals  # noqa: F401  # what is missing is said before the work
    if with_gl:
        require_gl(method)
    machine = this_machine()
    bandwidth = machine.memory_read_gb_s * 1e9
    settings = settings_from(METHODS[method].settings, changes or {})
    beside = against_rivals, with_gl
    found = [_bench_scene(s, method, settings, bandwidth, progress, *beside) for s in scenes]
    return finite({**provenance(), "machine": machine.as_dict(), "scenes": found})


def product_rate(product: Transfer | Prt | Polynomial) -> float:
    """Bytes of the transport that its products with a light, or with coefficients, read per second.

    The time of each is the median of its products alone, with nothing else of a frame in it.
    """
    if isinstance(product, Polynomial):
        edit = held_out_materials(product.view.scene, 1, seed=1)[0]
        frames = [product.relight(edit) for _ in range(PRODUCTS)]
        return product.bytes_in_hand / float(np.median([f.timings["evaluate"] for f in frames]))
    if isinstance(product, Prt):
        texels = 6 * product.settings.light_texels**2
        light = np.random.default_rng(1).normal(size=(texels, 3)).astype(np.float32)
        return product.bytes / repeat(lambda: product.multiply(light), PRODUCTS).median
    camera = product.view.scene.camera
    pixels, samples = camera.width * camera.height, len(product.cloud)
    light = np.random.default_rng(1).normal(size=(samples, 3)).astype(np.float32)
    tiles = pixel_tiles(camera.width, camera.height)
    seconds, size = 0.0, 0
    for rows, places, n in (
        (product.bounce, run_tiles(samples), samples),
        (product.final, tiles, pixels),
        (product.gloss, tiles, pixels),
    ):
        if len(rows.ids):
            timing = repeat(lambda: multiply(*rows, light, places, n), PRODUCTS)  # noqa: B023
            seconds += timing.median
            size += sum(array.nbytes for array in rows)
    return size / seconds


def _bench_scene(
    scene: Scene,
    method: str,
    settings: Any,
    bandwidth: float,
    progress: Progress,
    against_rivals: bool,
    with_gl: bool,
) -> dict[str, Any]:
    scene, edits = judged_on(scene, [method], EDITS, seed=1)
    with fresh(scene, method, settings, progress) as made:
        product: Any = made.product
        _, timing, parts = time_frames(product, edits, REPEATS, STEP * scene.diagonal)
        by_light = _by_light(edits, timing.seconds)
        if "camera" in METHODS[method].edits:
            views = held_out_views(scene, EDITS, seed=1)
            _, viewing, _ = time_frames(product, views, REPEATS, STEP * scene.diagonal)
            by_light["the camera moved"] = viewing.median
        if isinstance(product, Polynomial):
            by_light |= _sitting(product, scene, edits)
        if isinstance(product, Wavelets):
            by_light |= bench_codes.sitting(product, scene, settings, progress)
            rates = {"code_over_formula": bench_codes.code_over_formula()}
        else:
            rates = {"product_bandwidth": product_rate(product) / bandwidth}
        against: dict[str, Any] = {}
        if against_rivals:
            from engine.measure.rivals import rivals

            against["rivals"] = rivals(scene, product, edits[:RIVAL_EDITS], progress)
        if with_gl:
            step = STEP * scene.diagonal
            against["gl"] = {"an edit": by_backend(product, edits, step)}
            if "camera" in METHODS[method].edits:
                against["gl"]["the camera moved"] = by_backend(product, views, step)

    # Brute force gets the same job, the first of the edits. Its error falls as 1/√samples, so a
    # few samples tell how long it would take to an error that can be looked at.
    job, bounces = apply(scene, edits[0]), 1 if METHODS[method].lamps_alone else None
    result = render(job, samples=REFERENCE_SAMPLES, max_bounces=bounces, progress=progress)
    brute_force = result.seconds * (result.error / REFERENCE_ERROR) ** 2
    camera = scene.camera
    return {
        "scene": scene.name,
        "width": camera.width,
        "height": camera.height,
        "triangles": len(scene.geometry.triangles),
        "method": method,
        "settings": dataclasses.asdict(settings),
        "precompute_seconds": made.seconds,
        "phase_seconds": made.phases,
        "bytes": product.bytes,
        "frame_seconds": {
            "median": timing.median,
            "p95": timing.p95,
            "parts": parts,
            "lights": by_light,
        },
        "reference": {
            "samples": result.samples,
            "seconds": result.seconds,
            "error": result.error,
            "seconds_to_2_percent": brute_force,
        },
        "ratios": {
            **rates,
            "reference_over_frame": brute_force / timing.median,
            "precompute_over_reference": made.seconds / brute_force,
            **(against["rivals"]["ratios"] if against_rivals else {}),
        },
        **against,
    }


def _sitting(product: Polynomial, scene: Scene, edits: Sequence[Edits]) -> dict[str, float]:
    """Median seconds of what folds anew: another material in hand, and a moved light.

    In small pictures, as while the hand moves, and in whole ones, when it rests.
    """
    found = {}
    moves = [e.model_copy(update={"materials": edits[0].materials}) for e in _moves(scene)]
    for what, some in (("another material in hand", edits), ("a light moved", moves)):
        if not some:
            continue
        for scale, size in ((2, ", small picture"), (1, "")):
            took = [product.relight(edit, scale=scale).timings["total"] for edit in some]
            found[what + size] = float(np.median(took))
    return found


def _moves(scene: Scene) -> list[Edits]:
    return held_out_edits(scene, EDITS, seed=1) if scene.lights else []


def _by_light(edits: Sequence[Edits], seconds: Sequence[float]) -> dict[str, float]:
    """Median seconds by what each edit moves: the environment, a light, or a new one of a type."""
    times: dict[str, list[float]] = {}
    for turn, took in enumerate(seconds):
        if edits[turn % len(edits)].materials is not None:
            times.setdefault("the material in hand", []).append(took)
            continue
        if edits[turn % len(edits)].environment is not None:
            times.setdefault("the environment turned", []).append(took)
            continue
        light = (edits[turn % len(edits)].lights or [{}])[-1]
        name = f"a new {light['type']} light" if "type" in light else f"{light['id']!r} moved"
        times.setdefault(name, []).append(took)
    return {name: float(np.median(took)) for name, took in times.items()}
