"""Differences in false colour: blue where a picture is too dark, red where it is too bright."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import uniform_filter

from engine.measure.truth import Truth

COLOURS = "053061 2166ac 4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d b2182b 67001f"
"""sRGB at equal steps from too dark to too bright (Brewer's RdBu); so has the page's legend."""
FULL = (0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0)  # parts of the mean that full colours may stand for
SHOWN = 98.0  # per cent of the pixels that have colours of their own
QUIET, WIDEST = 0.02, 9  # noise that may be seen, a part of the mean; pixels it is averaged over
_BYTES = np.array([list(bytes.fromhex(colour)) for colour in COLOURS.split()])


def false_colour(
    image: NDArray[np.float32], reference: NDArray[np.float32], mask: NDArray[np.bool_], full: float
) -> NDArray[np.float64]:
    """(h, w, 3) sRGB in [0, 1] of two pictures (h, w, 3) in linear radiance.

    The colour is full where the mean of the channels is off by the part `full` of the reference's
    mean over the mask (h, w).
    """
    off = image.mean(axis=2) - reference.mean(axis=2)
    return _colours(off / _mean(reference, mask) / full)


@dataclass(frozen=True)
class Difference:
    """What a picture is off a noisy reference.

    colours   (h, w, 3) sRGB in [0, 1]
    full      the part of the reference's mean that the full colours stand for
    averaged  side of the square of pixels that each is the mean of
    """

    colours: NDArray[np.float64]
    full: float
    averaged: int


def difference(image: NDArray[np.float32], truth: Truth, kept: NDArray[np.bool_]) -> Difference:
    """Of a picture (h, w, 3), edges left out, in colours that show what there is.

    Over so many pixels that the noise of the reference is hardly seen, up to WIDEST.
    """
    mean = _mean(truth.image, kept)
    off = (image.mean(axis=2) - truth.image.mean(axis=2)).astype(np.float64) / mean
    noise = math.sqrt(float(truth.variance[kept].mean())) / mean if kept.any() else 0.0
    side = min(WIDEST, 1 + 2 * math.ceil((noise / QUIET - 1) / 2)) if noise > QUIET else 1
    # The mean of those that count: what lies beside an edge is not blurred into it.
    count, summed = (
        uniform_filter(x, side, mode="constant")
        for x in (kept.astype(np.float64), np.where(kept, off, 0.0))
    )
    off = np.where(count > 1e-9, summed / np.maximum(count, 1e-9), 0.0)
    most = float(np.percentile(np.abs(off[kept]), SHOWN)) if kept.any() else 0.0
    full = next((part for part in FULL if part >= most), FULL[-1])
    return Difference(_colours(off / full), full, side)


def _mean(reference: NDArray[np.float32], mask: NDArray[np.bool_]) -> float:
    return max(float(reference[mask].mean()) if mask.any() else 0.0, 1e-30)


def _colours(off: NDArray[np.floating]) -> NDArray[np.float64]:
    """(h, w, 3) of what is -1 to 1 from too dark to too bright."""
    steps = np.linspace(-1.0, 1.0, len(_BYTES))
    channels = [np.interp(np.clip(off, -1.0, 1.0), steps, channel) for channel in _BYTES.T]
    return np.stack(channels, axis=-1) / 255.0
