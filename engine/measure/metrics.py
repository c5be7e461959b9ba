"""How far a picture is from the truth, in numbers.

Pictures are (h, w, 3) float32 in linear radiance. `mask` is (h, w) bool and marks the pixels that
count. What an eye would judge (PSNR, colour difference, FLIP) is taken after the display
transform at an exposure in stops.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError
from engine.numerics.display import srgb_from_linear

Image = NDArray[np.float32]
Mask = NDArray[np.bool_]


def relative_l2(
    image: Image, reference: Image, mask: Mask | None = None, variance: Image | None = None
) -> float:
    """‖image - reference‖ / ‖reference‖ (`direct_to_indirect` §3.7), over the masked pixels.

    Infinite where the reference is black and the image is not, 0 where both are. Where the
    reference is a mean of random samples and `variance` (h, w, 3) that of each mean, its noise is
    taken out: E‖image - mean‖² exceeds ‖image - truth‖² by Σ variance, and so does E‖mean‖².
    """
    a, b = _pair(image, reference, mask)
    noise = 0.0 if variance is None else _noise(variance, mask)
    difference = max(0.0, float(np.sum((a - b) ** 2)) - noise)
    norm = max(0.0, float(np.sum(b**2)) - noise)
    if norm == 0.0:
        return math.inf if difference > 0.0 else 0.0
    return math.sqrt(difference / norm)


def resolution(reference: Image, variance: Image, mask: Mask | None = None) -> float:
    """The smallest `relative_l2` that a reference with this variance can tell from 0.

    For a perfect image ‖image - mean‖² scatters about Σ variance with a variance of 2 Σ v², v the
    sum over a pixel's channels, which may share their noise; this takes two standard deviations.
    """
    _, b = _pair(variance, reference, mask)
    v = variance.astype(np.float64).sum(axis=2)
    scatter = math.sqrt(2.0 * float(np.sum((v if mask is None else v[mask]) ** 2)))
    norm = max(0.0, float(np.sum(b**2)) - _noise(variance, mask))
    return math.sqrt(2.0 * scatter / norm) if norm > 0.0 else math.inf


def rmse(image: Image, reference: Image, mask: Mask | None = None) -> float:
    """Root of the mean squared difference, in units of radiance."""
    a, b = _pair(image, reference, mask)
    return math.sqrt(float(np.mean((a - b) ** 2))) if a.size else 0.0


def psnr(image: Image, reference: Image, mask: Mask | None = None, exposure: float = 0.0) -> float:
    """Peak signal-to-noise ratio of the displayed pictures, in decibels; infinite if equal."""
    _pair(image, reference, mask)
    error = rmse(_shown(image, exposure), _shown(reference, exposure), mask)
    return -20.0 * math.log10(error) if error > 0.0 else math.inf


def lab_difference(
    image: Image, reference: Image, mask: Mask | None = None, exposure: float = 0.0
) -> float:
    """Mean CIEDE2000 difference of the displayed pictures (CIE L*a*b*, D65); 1 is just visible."""
    # These packages come with the extra `chart`; the service does without them.
    from skimage.color import deltaE_ciede2000, rgb2lab

    _pair(image, reference, mask)
    lab = [rgb2lab(_shown(picture, exposure)) for picture in (image, reference)]
    difference = deltaE_ciede2000(*lab)
    kept = difference if mask is None else difference[mask]
    return float(kept.mean()) if kept.size else 0.0


def lab_distance(image: Image, reference: Image, exposure: float = 0.0) -> NDArray[np.float64]:
    """(h, w): distances of the displayed pictures in CIE L*a*b* (D65), the ΔE of 1976."""
    from skimage.color import rgb2lab

    _pair(image, reference, None)
    a, b = (rgb2lab(_shown(picture, exposure)) for picture in (image, reference))
    return np.asarray(np.linalg.norm(a - b, axis=2), np.float64)


def flip_ldr(
    image: Image, reference: Image, mask: Mask | None = None, exposure: float = 0.0
) -> float:
    """Mean LDR-FLIP of the displayed pictures, 0 to 1 (Andersson et al. 2020)."""
    _pair(image, reference, mask)
    return _flip(_shown(image, exposure), _shown(reference, exposure), "LDR", mask)


def flip_hdr(image: Image, reference: Image, mask: Mask | None = None) -> float:
    """Mean HDR-FLIP over the exposures that the reference asks for (Andersson et al. 2021).

    It does not depend on a common scale, so both are brought to a brightest value of 1: the
    evaluator ends the process where it finds the reference too dark. Against black it is 0 or 1.
    """
    _pair(image, reference, mask)
    top = float(reference.max(initial=0.0))
    if top == 0.0:
        return float(np.any(image[mask] > 0.0))
    a, b = (np.maximum(picture.astype(np.float64) / top, 0.0) for picture in (image, reference))
    return _flip(a.astype(np.float32), b.astype(np.float32), "HDR", mask)


METRICS: dict[str, Callable[..., float]] = {
    "relative_l2": relative_l2,
    "rmse": rmse,
    "psnr": psnr,
    "lab_difference": lab_difference,
    "flip_ldr": flip_ldr,
    "flip_hdr": flip_hdr,
}
"""Every metric by name; smaller is better, but for `psnr`."""


def flicker(
    frames: Sequence[Image],
    references: Sequence[Image],
    mask: Mask | None = None,
    variances: Sequence[Image] | None = None,
) -> float:
    """How much of what changes from frame to frame is not change of the truth, on average.

    ‖(f′ - f) - (r′ - r)‖ / ‖r‖ over frames f and references r in order: an error that stays where
    it is does not flicker. The references' noise, each its own, is taken out as in `relative_l2`.
    """
    found = []
    for k in range(len(frames) - 1):
        (a, r), (b, s) = (_pair(frames[j], references[j], mask) for j in (k, k + 1))
        noise = [0.0 if variances is None else _noise(variances[j], mask) for j in (k, k + 1)]
        moved = max(0.0, float(np.sum(((b - a) - (s - r)) ** 2)) - sum(noise))
        norm = max(0.0, float(np.sum(r**2)) - noise[0])
        found.append(math.sqrt(moved / norm) if norm > 0 else math.inf if moved > 0 else 0.0)
    return float(np.mean(found))


def auto_exposure(reference: Image) -> float:
    """Stops that bring the 99th percentile of the largest channel to 1; 0 for a black picture."""
    bright = float(np.percentile(reference.max(axis=2), 99))
    return -math.log2(bright) if bright > 0.0 else 0.0


def all_metrics(
    image: Image, reference: Image, mask: Mask, variance: Image | None = None
) -> dict[str, float]:
    """Every metric over the masked pixels, and `relative_l2_everywhere` over all.

    With the variance of the reference, the relative errors are free of its noise; the other
    figures hold it, so they never fall below what it alone gives.
    """
    exposure = auto_exposure(reference)
    shown = {"psnr", "lab_difference", "flip_ldr"}
    figures = {
        name: metric(image, reference, mask, *([exposure] if name in shown else []))
        for name, metric in METRICS.items()
    }
    figures["relative_l2"] = relative_l2(image, reference, mask, variance)
    everywhere = relative_l2(image, reference, None, variance)
    return {**figures, "relative_l2_everywhere": everywhere}


def _noise(variance: Image, mask: Mask | None) -> float:
    return float((variance if mask is None else variance[mask]).sum(dtype=np.float64))


def _shown(image: Image, exposure: float) -> NDArray[np.float32]:
    """sRGB signal in [0, 1], not yet rounded to bytes."""
    return srgb_from_linear(2.0**exposure * image.astype(np.float64)).astype(np.float32)


def _pair(image: Image, reference: Image, mask: Mask | None) -> tuple[NDArray, NDArray]:
    """Both as float64, masked; raises InputError where they cannot be compared."""
    if image.shape != reference.shape or (mask is not None and mask.shape != image.shape[:2]):
        shapes = f"{image.shape} and {reference.shape}, mask {mask if mask is None else mask.shape}"
        raise InputError(f"pictures of different shapes: {shapes}")
    if not (np.isfinite(image).all() and np.isfinite(reference).all()):
        raise InputError("a picture holds NaN or infinity")
    a, b = image.astype(np.float64), reference.astype(np.float64)
    return (a, b) if mask is None else (a[mask], b[mask])


def _flip(image: Image, reference: Image, dynamic_range: str, mask: Mask | None) -> float:
    import flip_evaluator

    error, _, _ = flip_evaluator.evaluate(
        np.ascontiguousarray(reference, np.float32),
        np.ascontiguousarray(image, np.float32),
        dynamic_range,
        applyMagma=False,
    )
    error = error.reshape(image.shape[:2])
    kept = error if mask is None else error[mask]
    return float(kept.mean()) if kept.size else 0.0
