"""What the same picture costs those who render it anew: Mitsuba 3, alone and denoised.

All get the same edit of the same scene. Ours is a moved light, from edit to linear frame. Mitsuba
renders the edited scene from nothing but its finished scene and compiled kernels: neither is
timed. Its variant is the fastest that runs here. The denoiser is Open Image Denoise with albedo
and normals of the fixed view, which are precomputed without noise, as our transport is.

Each is judged against converged pictures of its own kind, since the two define a spot's penumbra,
say, each in its own way (`mitsuba_scene.differences`), and edges are left out for all.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.measure.edges import pixels_that_count
from engine.measure.halves import Halves
from engine.measure.mitsuba_renderer import Mitsuba, take_fastest
from engine.measure.probes import nudged
from engine.measure.sweep import STEP, time_frames
from engine.measure.timing import repeat
from engine.measure.truth import truth
from engine.methods.base import Product, Progress, silent
from engine.scene.edits import Edits, apply
from engine.scene.scene import Scene
from engine.store import Store

REPEATS = 9
REFERENCE_ERROR = 0.05  # of each half, whose noise is taken out: see `halves`
REFERENCE_SAMPLES = 256  # of each of Mitsuba's
MOST_SAMPLES = 1024  # that the denoiser is given in the end
QUALITIES = ("Fast", "Balanced", "High")  # the denoiser's

Image = NDArray[np.float32]


def rivals(
    scene: Scene,
    product: Product,
    edits: Sequence[Edits],
    progress: Progress = silent,
    *,
    reference_error: float = REFERENCE_ERROR,
    reference_samples: int = REFERENCE_SAMPLES,
    store: Store | None = None,
) -> dict[str, Any]:
    """Times of ours, Mitsuba's and Mitsuba's denoised pictures of every edit, as JSON."""
    variant, version = take_fastest()

    from engine.measure.mitsuba_scene import differences

    found: list[dict[str, Any]] = []
    for number, edit in enumerate(edits):
        progress("rivals", number, len(edits))
        mask = pixels_that_count(apply(scene, edit))
        first, second = (
            truth(scene, edit, reference_error, store or Store(), progress, seed).image
            for seed in (0, 1)
        )
        halves = Halves(first, second, mask)
        step = STEP * scene.diagonal
        # Half a step aside, where the product has never been and can remember nothing.
        _, timing, _ = time_frames(product, [nudged(edit, step / 2)], REPEATS, step)
        image = product.relight(edit).image
        ours = {
            "seconds": timing.median,
            "relative_l2": halves.relative_l2(image),
            "psnr": halves.psnr(image),
        }
        theirs = Mitsuba(apply(scene, edit))
        mitsuba, judge = _plain(theirs, ours["relative_l2"], reference_samples, mask)
        denoised = _denoised(theirs, ours["psnr"], judge)
        found.append(
            {
                "edit": edit.model_dump(mode="json", exclude_none=True),
                "differences": differences(apply(scene, edit)),
                "ours": ours,
                "mitsuba": mitsuba,
                "denoised": denoised,
                "mitsuba_over_ours": mitsuba["seconds"] / ours["seconds"],
                "denoised_over_ours": denoised["seconds"] / ours["seconds"],
            }
        )
    progress("rivals", len(edits), len(edits))
    names = ("mitsuba_over_ours", "denoised_over_ours")
    medians = {name: float(np.median([f[name] for f in found])) for name in names}
    return {"variant": variant, "version": version, "edits": found, "ratios": medians}


def _plain(
    theirs: Mitsuba, error: float, samples: int, mask: NDArray[np.bool_]
) -> tuple[dict[str, float], Halves]:
    """What Mitsuba alone needs for a relative L2 error, and converged pictures of it.

    Two pictures tell its noise. Noise falls as 1/√samples and time grows as samples.
    """
    pictures: list[Image] = []
    # The first compiles.
    timing = repeat(lambda: pictures.append(theirs.picture(samples, len(pictures))), count=2)
    judge = Halves(pictures[1], pictures[2], mask)
    needed = (judge.noise() / error) ** 2
    return {
        "samples": samples * needed,
        "seconds": timing.median * needed,
        "measured_samples": samples,
        "measured_seconds": timing.median,
        "measured_relative_l2": judge.noise(),
    }, judge


def _denoised(theirs: Mitsuba, psnr: float, judge: Halves) -> dict[str, Any]:
    """What Mitsuba and the denoiser need for a PSNR, at the quality that is there first."""
    best: dict[str, Any] = {"reached": False, "seconds": math.inf}
    for quality in QUALITIES:
        points: list[dict[str, float]] = []
        samples = 1
        # Double the samples until it is there, or another quality was there before.
        while samples <= MOST_SAMPLES:
            points.append(_denoised_point(theirs, quality, samples, judge))
            if points[-1]["psnr"] >= psnr or points[-1]["seconds"] > best["seconds"]:
                break
            samples *= 2
        reached = points[-1]["psnr"] >= psnr
        found = {
            "quality": quality,
            "reached": reached,
            "seconds": _seconds_to(psnr, points),
            "points": points,
        }
        # Where none gets there, what was tried is a lower bound.
        if reached > best["reached"] or (
            reached == best["reached"] and found["seconds"] < best["seconds"]
        ):
            best = found
    return best


def _denoised_point(theirs: Mitsuba, quality: str, samples: int, judge: Halves) -> dict[str, float]:
    pictures: list[Image] = []
    timing = repeat(
        lambda: pictures.append(theirs.denoised(samples, 10 + len(pictures), quality)), count=3
    )
    reached = float(np.mean([judge.psnr(picture) for picture in pictures]))
    return {"samples": samples, "seconds": timing.median, "psnr": reached}


def _seconds_to(psnr: float, points: Sequence[dict[str, float]]) -> float:
    """Time to a PSNR between the last two points, log time against decibels; else of the last."""
    last = points[-1]
    if len(points) == 1 or last["psnr"] < psnr:
        return last["seconds"]
    before = points[-2]
    share = (psnr - before["psnr"]) / (last["psnr"] - before["psnr"])
    low, high = math.log(before["seconds"]), math.log(last["seconds"])
    return math.exp(low + share * (high - low))
