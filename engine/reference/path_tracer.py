"""The path tracer that referees every method: unbiased, unclamped, with its own error bars."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.methods.base import Progress, silent
from engine.reference.accumulate import accumulate
from engine.reference.limits import Limits
from engine.reference.paths import Paths, add_unshadowed, bounce_paths, paths, shadows
from engine.reference.result import Reference
from engine.reference.world import World
from engine.scene.scene import Scene

DEFAULT_ERROR = 0.01
UNLIMITED = 1 << 30


def render(
    scene: Scene,
    *,
    samples: int | None = None,
    error: float | None = None,
    max_seconds: float | None = None,
    seed: int = 0,
    max_bounces: int | None = None,
    counted: NDArray[np.bool_] | None = None,
    progress: Progress = silent,
) -> Reference:
    """Path-trace the scene from its camera until any of three limits is reached.

    samples, error, max_seconds  see `Limits`; without any of them the error is DEFAULT_ERROR
    max_bounces  reflections after which light is cut off, to compare with methods that do so;
        0 is emission alone, 1 direct light; None follows light to its end (unbiased)
    counted  (height, width), the pixels whose error is meant; None for all

    Equal seeds and sample counts give equal bytes. Raises InputError for values out of range.
    """
    last = UNLIMITED if max_bounces is None else max_bounces
    if last < 0:
        raise InputError(f"{max_bounces} is below 0", field="max_bounces")
    if samples is None and error is None and max_seconds is None:
        error = DEFAULT_ERROR
    limits = Limits(samples, error, max_seconds)

    def trace(
        scene: Scene, packed: World, seed: int, index: NDArray[np.int64], rays: Paths
    ) -> tuple[NDArray[np.float64], int]:
        return _trace(scene, packed, seed, index, rays, last)

    return accumulate(scene, trace, limits, seed, progress, counted)


def _trace(
    scene: Scene,
    packed: World,
    seed: int,
    index: NDArray[np.int64],
    now: Paths,
    last: int,
) -> tuple[NDArray[np.float64], int]:
    n = len(index)
    radiance = np.zeros((n, 6))
    following, shadow = paths(n), shadows(n)
    traced, bounce = 0, 0
    while n:
        hits = scene.rays.intersect(now.origin[:n], now.direction[:n])
        shadowed, survivors = bounce_paths(
            packed, seed, bounce, last, now, n, hits, index, radiance, shadow, following
        )
        hidden = scene.rays.occluded(
            shadow.origin[:shadowed], shadow.direction[:shadowed], shadow.limit[:shadowed]
        )
        bounce += 1
        add_unshadowed(shadow, shadowed, hidden, bounce, radiance)
        traced += n + shadowed
        now, following, n = following, now, survivors
    return radiance, traced
