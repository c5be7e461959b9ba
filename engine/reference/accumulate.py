"""Passes over the picture until its error is small enough.

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
from engine.methods.base import Progress
from engine.numerics.parallel import for_ranges
from engine.reference.limits import Limits
from engine.reference.paths import Paths, paths, pixel_jitter
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


class Wave(NamedTuple):
    """Pixels [first, stop) and the samples [sample, sample + samples) of each."""

    first: int
    stop: int
    sample: int
    samples: int


Trace = Callable[[Scene, World, int, NDArray[np.int64], Paths], tuple[NDArray[np.float64], int]]
"""trace(scene, world, seed, index (n,), camera rays) -> (n, 6) direct and indirect, rays traced."""


def accumulate(
    scene: Scene,
    trace: Trace,
    limits: Limits,
    seed: int,
    progress: Progress,
    counted: NDArray[np.bool_] | None = None,
) -> Reference:
    """Make passes over the picture with `trace` until a limit is reached.

    counted  (height, width), the pixels whose error is meant; None for all
    """
    limits.check()
    if not 0 <= seed < 1 << 63:
        raise InputError(f"{seed} is not in [0, 2^63)", field="seed")
    start = time.perf_counter()
    packed = world(scene)
    width, height = scene.camera.width, scene.camera.height
    sums = np.zeros((width * height, MOMENTS))
    meant = slice(None) if counted is None else counted.ravel()
    done = rays = 0

    def wave_sums(wave: Wave) -> tuple[NDArray[np.float64], int]:
        index, now = _camera_rays(scene, seed, wave)
        radiance, traced = trace(scene, packed, seed, index, now)
        part = np.zeros((wave.stop - wave.first, MOMENTS))
        add_moments(radiance, wave.samples, part)
        return part, traced

    while True:
        error = relative_error(*mean_and_variance(sums[meant, :6], done)) if done else math.inf
        spent = time.perf_counter() - start
        more = limits.next_pass(done, error, spent)
        if more == 0:
            return reference(sums, height, width, done, spent, rays, counted)
        total = limits.expected(done, error, spent)
        waves = list(_waves(width * height, done, more))
        for group in range(0, len(waves), WAVES):
            some = waves[group : group + WAVES]
            for wave, (part, traced) in zip(some, _all(wave_sums, some), strict=True):
                sums[wave.first : wave.stop] += part
                rays += traced
            reached = done + more * min(1.0, (group + WAVES) / len(waves))
            progress("reference", reached, max(reached, total if total < math.inf else done + more))
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
