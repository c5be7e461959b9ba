"""Small scenes with a known answer, and how to compare a noisy picture with it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from engine.reference import Reference
from engine.scene.build import build
from engine.scene.open import describe
from engine.scene.scene import Scene

FLOOR = {
    "name": "floor",
    "mesh": {"shape": "rectangle", "size": [40, 40]},
    "material": "floor",
    "transform": {"rotate_degrees": [-90, 0, 0]},
}


def scene(**document: Any) -> Scene:
    """A scene of its description; without `environment` and `lights` there is none."""
    return build(describe({"lights": [], **document}), Path())


def floor(material: dict[str, Any], camera: dict[str, Any], **light: Any) -> Scene:
    """A large plane y = 0, seen by a camera."""
    return scene(camera=camera, materials={"floor": material}, objects=[FLOOR], **light)


def assert_mean(result: Reference, expected: Any, precision: float) -> None:
    """Every pixel and the whole picture are as expected, (h, w, 3) or a colour, within noise.

    `precision` is the relative standard error that the whole picture must have at most, so that
    the comparison means something.
    """
    image, variance = result.image.astype(np.float64), result.variance.astype(np.float64)
    want = np.broadcast_to(np.asarray(expected, np.float64), image.shape)
    # What float32 rays and float32 results cannot resolve counts as noise.
    spread = np.sqrt(variance + (3e-5 * want) ** 2)
    z = np.abs(image - want) / spread
    # Pixels have skewed samples, so their tails are heavier than normal: leave room.
    limit = 1.5 * stats.norm.isf(1e-4 / z.size)
    assert z.max() < limit, f"a pixel is {z.max():.1f} standard errors off"
    error = np.sqrt(variance.sum(axis=(0, 1))) / want.sum(axis=(0, 1))
    bias = image.sum(axis=(0, 1)) / want.sum(axis=(0, 1)) - 1
    assert np.all(error <= precision), f"the mean is known to {error.max():.2g} only"
    assert np.all(np.abs(bias) < 4.5 * error + 3e-5), f"mean off by {bias}, error {error}"
