"""Errors against two independent references, in which the noise of neither is left.

Let a = t + n and b = t + m be references of the truth t whose noises n, m know nothing of each
other. Then E[(x - a)(x - b)] = (x - t)² for any picture x that knows nothing of them either, and
E[ab] = t². No variance has to be believed, and it goes for what is shown on a display as well, but
for the bend of its curve over the noise.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.measure.metrics import Image, Mask, auto_exposure
from engine.numerics.display import srgb_from_linear

Show = Callable[[Image, float], NDArray[np.float64]]


@dataclass(frozen=True)
class Halves:
    """Two references of one picture.

    first, second  (h, w, 3) float32, linear radiance
    mask           (h, w) bool, the pixels that count
    """

    first: Image
    second: Image
    mask: Mask

    def relative_l2(self, image: Image) -> float:
        """As `engine.measure.metrics.relative_l2`; never below what the noise lets one see."""
        found = self._mean(_linear, image, 0.0)
        return math.sqrt(max(found, self._least(_linear, 0.0)) / self._power())

    def psnr(self, image: Image) -> float:
        """As `engine.measure.metrics.psnr`, at an exposure that the references ask for."""
        exposure = auto_exposure(0.5 * (self.first + self.second))
        found = max(self._mean(_shown, image, exposure), self._least(_shown, exposure))
        return -10.0 * math.log10(found) if found > 0.0 else math.inf

    def noise(self) -> float:
        """Relative L2 error of either reference."""
        d = (self.first - self.second)[self.mask].astype(np.float64)
        return math.sqrt(float(np.mean(d * d)) / 2 / self._power())

    def _power(self) -> float:
        a, b = (p[self.mask].astype(np.float64) for p in (self.first, self.second))
        return max(float(np.mean(a * b)), 1e-300)

    def _mean(self, show: Show, image: Image, exposure: float) -> float:
        x, a, b = (show(p[self.mask], exposure) for p in (image, self.first, self.second))
        return float(np.mean((x - a) * (x - b)))

    def _least(self, show: Show, exposure: float) -> float:
        """Two standard deviations of `_mean` for a perfect picture.

        A pixel's n·m has the variance v² of both noises, v the sum over its channels, which may
        share their noise; (a - b)² is 2 v on average.
        """
        a, b = (show(p[self.mask], exposure) for p in (self.first, self.second))
        v = np.sum((a - b) ** 2, axis=-1) / 2
        return 2.0 * math.sqrt(float(np.sum(v * v))) / a.size


def _linear(values: Image, exposure: float) -> NDArray[np.float64]:
    return values.astype(np.float64)


def _shown(values: Image, exposure: float) -> NDArray[np.float64]:
    """sRGB signal, 0 to 1."""
    return srgb_from_linear(2.0**exposure * values.astype(np.float64)).astype(np.float64)
