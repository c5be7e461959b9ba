"""A small picture of an environment's map, to find one's way on it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.light.cube_light import resampled
from engine.light.environment import Environment
from engine.light.environment_samples import averaged
from engine.numerics.display import to_srgb8

WIDTH, HEIGHT = 256, 128
MEAN = 0.25  # of what is shown, before the tone curve
SHARE = 0.9  # of the sphere that is brightened or darkened to that mean; the rest may be suns


def thumbnail(environment: Environment) -> NDArray[np.uint8]:
    """(HEIGHT, WIDTH, 3) sRGB of the map, not turned, without the area light.

    It is as bright as shows it well, whatever the intensity.
    """
    image = resampled(averaged(environment.radiance), HEIGHT, WIDTH)
    rows = np.sin(np.pi * (np.arange(HEIGHT) + 0.5) / HEIGHT)
    bright = image.mean(axis=2)
    order = np.argsort(bright, axis=None)
    weight = np.broadcast_to(rows[:, None], bright.shape).ravel()[order]
    kept = np.cumsum(weight) <= SHARE * weight.sum()
    mean = float(np.average(bright.ravel()[order][kept], weights=weight[kept]))
    return to_srgb8(image, np.log2(MEAN / mean) if mean > 0 else 0.0)
