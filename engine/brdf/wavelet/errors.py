"""How far the values of a code are from those that were encoded."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.brdf.wavelet.analysis import Array, Grid


@dataclass(frozen=True, eq=False)
class Errors:
    """Of values against those that are right, both (θ, φ, down, across, 3).

    off       what they are off, sr⁻¹
    relative  the same, over what is right and the floor of its channel
    light     part of all light, from everywhere, that is reflected where it should not be
    """

    off: Array
    relative: Array
    light: float

    @property
    def mean(self) -> float:
        """Mean relative error over all samples and channels."""
        return float(self.relative.mean())

    @property
    def p99(self) -> float:
        """99th percentile of the same."""
        return float(np.quantile(self.relative, 0.99))

    @property
    def rms(self) -> float:
        """Root mean square of what they are off, sr⁻¹."""
        return float(np.sqrt((self.off**2).mean()))

    def as_dict(self) -> dict[str, float]:
        """As JSON."""
        return {name: getattr(self, name) for name in ("mean", "p99", "rms", "light")}


def errors_of(
    found: NDArray[np.floating], right: NDArray[np.floating], grid: Grid, floor: Array
) -> Errors:
    """Of tables on a grid; floor (3,) sr⁻¹, see `floors`."""
    off = np.abs(found - np.asarray(right, np.float64))
    share = np.multiply.outer(*grid.weights)[..., None, None] * grid.incident_weights
    light = float(np.einsum("abcdk,abcd->", right, share))
    wrong = float(np.einsum("abcdk,abcd->", off, share))
    return Errors(off, off / (right + floor), wrong / (2 * light) if light > 0 else 0.0)


def floors(values: NDArray[np.floating], part: float) -> Array:
    """(3,) sr⁻¹: that part of each channel's mean; a black one has that of all (§5.1: εμ)."""
    channels = values.mean(axis=(0, 1, 2, 3), dtype=np.float64)
    return part * np.where(channels > 0, channels, channels.mean() or 1.0)
