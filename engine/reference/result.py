"""What the reference returns: an image with its own uncertainty."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray

# Per pixel: sums of samples and of their squares, of the whole light and of its indirect part.
MOMENTS = 12


@dataclass(frozen=True)
class Reference:
    """A converged picture, linear radiance; images are (height, width, 3) float32.

    image              mean over the samples of each pixel (box filter)
    variance           of each pixel's mean, estimated from its samples
    direct             light that was reflected at most once, emission included
    indirect           the rest; `image` is the sum of the two
    indirect_variance  of the means in `indirect`
    samples            per pixel
    seconds            wall-clock
    rays               traced, shadow rays included
    counted            (height, width), the pixels whose error is meant; None for all
    """

    image: NDArray[np.float32]
    variance: NDArray[np.float32]
    direct: NDArray[np.float32]
    indirect: NDArray[np.float32]
    indirect_variance: NDArray[np.float32]
    samples: int
    seconds: float
    rays: int
    counted: NDArray[np.bool_] | None = None

    @property
    def error(self) -> float:
        """Estimated relative L2 error of `image`: root of (sum of variances / sum of squares)."""
        meant = slice(None) if self.counted is None else self.counted
        return relative_error(self.image[meant], self.variance[meant])


def relative_error(mean: NDArray[np.floating], variance: NDArray[np.floating]) -> float:
    """√(Σ variance / (Σ mean² - Σ variance)): the mean's own square is too large by its variance.

    Infinite where noise is all there is, 0 for a black picture without noise.
    """
    noise = float(variance.sum(dtype=np.float64))
    signal = float(np.square(mean, dtype=np.float64).sum()) - noise
    if noise == 0.0:
        return 0.0
    return math.sqrt(noise / signal) if signal > 0.0 else math.inf


@njit(cache=True, nogil=True)
def add_moments(radiance, samples, sums):
    """Sum (n, 6) direct and indirect radiance of n / samples pixels into sums (pixels, 12)."""
    for pixel in range(sums.shape[0]):
        for k in range(pixel * samples, (pixel + 1) * samples):
            for c in range(3):
                indirect = radiance[k, 3 + c]
                whole = radiance[k, c] + indirect
                sums[pixel, c] += whole
                sums[pixel, 3 + c] += whole * whole
                sums[pixel, 6 + c] += indirect
                sums[pixel, 9 + c] += indirect * indirect


def mean_and_variance(
    sums: NDArray[np.float64], samples: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Mean and variance of the mean from (..., 6) sums; one sample tells nothing: infinite."""
    mean = sums[..., :3] / samples
    if samples < 2:
        return mean, np.full_like(mean, np.inf)
    spread = sums[..., 3:] / samples - mean * mean
    # What rounding leaves of a constant must not count as noise.
    spread[spread < 1e-13 * mean * mean] = 0.0
    return mean, spread / (samples - 1)


def reference(
    sums: NDArray[np.float64],
    height: int,
    width: int,
    samples: int,
    seconds: float,
    rays: int,
    counted: NDArray[np.bool_] | None = None,
) -> Reference:
    """The picture of (pixels, 12) sums."""
    image, variance = mean_and_variance(sums[:, :6], samples)
    indirect, indirect_variance = mean_and_variance(sums[:, 6:], samples)

    def picture(values: NDArray[np.float64]) -> NDArray[np.float32]:
        return values.astype(np.float32).reshape(height, width, 3)

    return Reference(
        image=picture(image),
        variance=picture(variance),
        direct=picture(image - indirect),
        indirect=picture(indirect),
        indirect_variance=picture(indirect_variance),
        samples=samples,
        seconds=seconds,
        rays=rays,
        counted=counted,
    )
