"""The path tracer that referees every method: unbiased, unclamped, with its own error bars.

Work is cut into waves of a few thousand samples; a wave is traced to its end by one thread, kernels
and Embree in turn. Random numbers depend on seed, pixel, sample and vertex alone, and sums are
taken in a fixed order, so equal seeds and sample counts give equal bytes on any number of threads.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.methods.base import Progress, silent
from engine.numerics.parallel import for_ranges
from engine.reference.paths import (
    Paths,
    add_unshadowed,
    bounce_paths,
    paths,
    pixel_jitter,
    shadows,
)
from engine.reference.result import (
    MOMENTS,
    Reference,
    add_moments,
    mean_and_variance,
    reference,
    relative_error,
)
from engine.reference.world import World, world
from engine.scene.scene import Scene

WAVE = 16384  # samples traced together by one thread: large enough for Embree, small for the cache
WAVES = 32  # between two reports of progress
FIRST_PASS = 16  # samples per pixel before the error is believed at all
LEAST_SAMPLES = 64  # before a requested error may end the work
DEFAULT_ERROR = 0.01
UNLIMITED = 1 << 30


class Wave(NamedTuple):
    """Pixels [first, stop) and the samples [sample, sample + samples) of each."""

    first: int
    stop: int
    sample: int
    samples: int


Trace = Callable[[Scene, World, int, NDArray[np.int64], Paths], tuple[NDArray[np.float64], int]]
"""trace(scene, world, seed, index (n,), camera rays) -> (n, 6) direct and indirect, rays traced."""


def render(
    scene: Scene,
    *,
    samples: int | None = None,
    error: float | None = None,
    max_seconds: float | None = None,
    seed: int = 0,
    max_bounces: int | None = None,
    progress: Progress = silent,
) -> Reference:
    """Path-trace the scene from its camera until any of three limits is reached.

    samples      per pixel
    error        relative L2 error of the picture, estimated from its own variance
    max_seconds  wall-clock, kept between passes over the picture; at least one pass is made
    max_bounces  reflections after which light is cut off, for comparison with methods that do so;
                 0 is emission alone, 1 direct light; None follows light to its end (unbiased)

    Without any limit the error is DEFAULT_ERROR. Raises InputError for values out of range.
    """
    last = UNLIMITED if max_bounces is None else max_bounces
    if last < 0:
        raise InputError(f"{max_bounces} is below 0", field="max_bounces")

    def trace(
        scene: Scene, packed: World, seed: int, index: NDArray[np.int64], rays: Paths
    ) -> tuple[NDArray[np.float64], int]:
        return _trace(scene, packed, seed, index, rays, last)

    return accumulate(
        scene,
        trace,
        samples=samples,
        error=error,
        max_seconds=max_seconds,
        seed=seed,
        progress=progress,
    )


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


def accumulate(
    scene: Scene,
    trace: Trace,
    *,
    samples: int | None,
    error: float | None,
    max_seconds: float | None,
    seed: int,
    progress: Progress,
) -> Reference:
    """Make passes over the picture with `trace` until a limit is reached; see `render`."""
    _check_limits(samples, error, max_seconds, seed)
    if samples is None and error is None and max_seconds is None:
        error = DEFAULT_ERROR
    start = time.perf_counter()
    packed = world(scene)
    width, height = scene.camera.width, scene.camera.height
    sums = np.zeros((width * height, MOMENTS))
    done = rays = 0

    def wave_sums(wave: Wave) -> tuple[NDArray[np.float64], int]:
        index, now = _camera_rays(scene, seed, wave)
        radiance, traced = trace(scene, packed, seed, index, now)
        part = np.zeros((wave.stop - wave.first, MOMENTS))
        add_moments(radiance, wave.samples, part)
        return part, traced

    while True:
        spent = time.perf_counter() - start
        more = _next_pass(sums, done, spent, samples, error, max_seconds)
        if more == 0:
            return reference(sums, height, width, done, spent, rays)
        waves = list(_waves(width * height, done, more))
        for group in range(0, len(waves), WAVES):
            progress("reference", *_done(sums, done, spent, samples, error, max_seconds))
            results = _all(wave_sums, waves[group : group + WAVES])
            for wave, (part, traced) in zip(waves[group : group + WAVES], results, strict=True):
                sums[wave.first : wave.stop] += part
                rays += traced
        done += more


def _all(
    work: Callable[[Wave], tuple[NDArray[np.float64], int]], waves: list[Wave]
) -> list[tuple[NDArray[np.float64], int]]:
    results: dict[int, tuple[NDArray[np.float64], int]] = {}

    def some(start: int, stop: int) -> None:
        for k in range(start, stop):
            results[k] = work(waves[k])

    for_ranges(some, len(waves), grain=1)
    return [results[k] for k in range(len(waves))]


def _waves(pixels: int, done: int, more: int) -> Iterator[Wave]:
    """Cut `more` samples of every pixel into waves of about WAVE samples."""
    deep = min(more, WAVE)
    wide = max(1, WAVE // deep)
    for first in range(0, pixels, wide):
        for sample in range(done, done + more, deep):
            yield Wave(first, min(first + wide, pixels), sample, min(deep, done + more - sample))


def _camera_rays(scene: Scene, seed: int, wave: Wave) -> tuple[NDArray[np.int64], Paths]:
    """Numbers and camera rays of a wave's samples, those of a pixel side by side."""
    camera = scene.camera
    pixels = camera.width * camera.height
    sample = np.arange(wave.sample, wave.sample + wave.samples, dtype=np.int64) * pixels
    index = (np.arange(wave.first, wave.stop, dtype=np.int64)[:, None] + sample).ravel()
    xy = np.zeros((2, len(index)))
    pixel_jitter(seed, index, camera.width, pixels, xy)
    rays = paths(len(index))
    rays.origin[:] = camera.position
    rays.direction[:] = camera.directions(xy[0], xy[1])
    return index, rays


def _check_limits(
    samples: int | None, error: float | None, max_seconds: float | None, seed: int
) -> None:
    if samples is not None and samples < 1:
        raise InputError(f"{samples} is below 1", field="samples")
    if error is not None and not 0 < error < math.inf:
        raise InputError(f"{error} is not a positive number", field="error")
    if max_seconds is not None and not max_seconds > 0:
        raise InputError(f"{max_seconds} is not above 0", field="max_seconds")
    if not 0 <= seed < 1 << 63:
        raise InputError(f"{seed} is not in [0, 2^63)", field="seed")


def _next_pass(
    sums: NDArray[np.float64],
    done: int,
    spent: float,
    samples: int | None,
    error: float | None,
    max_seconds: float | None,
) -> int:
    """Samples per pixel of the next pass, 0 when a limit is reached."""
    more = FIRST_PASS if done == 0 else done
    if error is not None and done >= FIRST_PASS:
        now = _error(sums, done)
        if now <= error and done >= LEAST_SAMPLES:
            return 0
        # Error falls as one over the root of the samples; do not trust a guess beyond fourfold.
        needed = math.ceil(done * min(4.0, (now / error) ** 2)) if math.isfinite(now) else 2 * done
        more = max(needed, LEAST_SAMPLES) - done
        more = max(more, done // 8, 1)
    if max_seconds is not None:
        if done == 0:
            more = 1
        elif spent >= max_seconds:
            return 0
        else:
            more = min(more, max(1, int(done * (max_seconds - spent) / spent)))
    if samples is not None:
        more = min(more, samples - done)
    return more


def _error(sums: NDArray[np.float64], done: int) -> float:
    return relative_error(*mean_and_variance(sums[:, :6], done))


def _done(
    sums: NDArray[np.float64],
    done: int,
    spent: float,
    samples: int | None,
    error: float | None,
    max_seconds: float | None,
) -> tuple[float, float]:
    """(done, total) of the limit that is nearest."""
    parts = [(0.0, 1.0)]
    if samples is not None:
        parts.append((float(done), float(samples)))
    if max_seconds is not None:
        parts.append((min(spent, max_seconds), max_seconds))
    if error is not None and done >= 2:
        now = _error(sums, done)
        parts.append((min(1.0, (error / now) ** 2) if now > 0 else 1.0, 1.0))
    return max(parts, key=lambda part: part[0] / part[1])
