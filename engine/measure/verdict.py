"""One picture against its reference, in numbers: what a person wants to hear of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

from engine.measure.metrics import Image, Mask, psnr, relative_l2, resolution
from engine.measure.truth import Truth
from engine.reference.result import relative_error


@dataclass(frozen=True)
class Verdict:
    """How far a picture is off; None stands for what is not finite.

    error   relative L2, edges left out, the reference's noise taken out
    least   the smallest error that this noise lets one see
    psnr    decibels of the pictures as they are shown, with the noise
    noise   relative L2 error of the reference itself, over the same pixels
    """

    error: float | None
    least: float | None
    psnr: float | None
    noise: float | None


def verdict(image: Image, truth: Truth, kept: Mask, exposure: float) -> Verdict:
    """Of a picture (h, w, 3) over the pixels that count, (h, w) bool; exposure in stops."""
    found = (
        relative_l2(image, truth.image, kept, truth.variance),
        resolution(truth.image, truth.variance, kept),
        psnr(image, truth.image, kept, exposure),
        relative_error(truth.image[kept], truth.variance[kept]),
    )
    return Verdict(*(value if math.isfinite(value) else None for value in found))
