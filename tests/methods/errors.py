"""How far a picture is from a noisy reference, and how noisy that is."""

from __future__ import annotations

import numpy as np


def error_and_noise(
    image: np.ndarray, truth: np.ndarray, variance: np.ndarray
) -> tuple[float, float]:
    """Relative L2 error with the reference's own noise taken out of it, and that noise."""
    signal = (truth.astype(np.float64) ** 2).sum() - variance.sum()
    noise = variance.sum() / signal
    off = ((image - truth).astype(np.float64) ** 2).sum() / signal
    return float(np.sqrt(max(0.0, off - noise))), float(np.sqrt(noise))
