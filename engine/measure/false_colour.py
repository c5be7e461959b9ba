"""Differences in false colour: blue where a picture is too dark, red where it is too bright."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

COLOURS = "053061 2166ac 4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d b2182b 67001f"
"""sRGB at equal steps from too dark to too bright (Brewer's RdBu); so has the page's legend."""
_BYTES = np.array([list(bytes.fromhex(colour)) for colour in COLOURS.split()])


def false_colour(
    image: NDArray[np.float32], reference: NDArray[np.float32], mask: NDArray[np.bool_], full: float
) -> NDArray[np.float64]:
    """(h, w, 3) sRGB in [0, 1] of two pictures (h, w, 3) in linear radiance.

    The colour is full where the mean of the channels is off by the part `full` of the reference's
    mean over the mask (h, w).
    """
    scale = max(float(reference[mask].mean()) if mask.any() else 0.0, 1e-30)
    off = np.clip((image.mean(axis=2) - reference.mean(axis=2)) / scale / full, -1.0, 1.0)
    steps = np.linspace(-1.0, 1.0, len(_BYTES))
    channels = [np.interp(off, steps, channel) for channel in _BYTES.T]
    return np.stack(channels, axis=-1) / 255.0
