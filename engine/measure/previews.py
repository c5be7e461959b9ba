"""A preview of a product: the same method with settings that take seconds, half as wide and high.

It is made before the whole product where that takes long, so that there is soon a picture with
indirect light. Whether it does is told by the rays that it casts, which are known before.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.diagnosis import Diagnosis
from engine.methods.fixed_view.importance import LIGHTS
from engine.numerics.parallel import thread_count
from engine.scene.scene import Scene

SHOWN = Diagnosis(
    "preview_shown",
    "This is a preview, made quickly with few samples: the whole precompute is not there yet.",
)

LONG = 10.0  # seconds of a whole product that a preview is worth it for
RATE = 7e5  # rays a second and thread, with all that is done with them

PREVIEWS: dict[str, dict[str, Any]] = {
    "direct_to_indirect": {
        "gather_samples": 4096,
        "coefficients": 20,
        "bounce_coefficients": 20,
        "gloss_coefficients": 12,
        "view_rays": 64,
        "gloss_rays": 32,
        "bounce_rays": 89,
        "opening_rays": 89,
    },
    "brdf_editing": {
        "gather_samples": 4096,
        "view_rays": 64,
        "bounce_rays": 89,
        "bounce_coefficients": 20,
    },
}
"""Per method the most that a preview has of settings.

Of those of a fixed view: `wavelet_brdf` draws direct light without its codes, and for `glossy_prt`
none were found yet that are quick.
"""


def halved(scene: Scene) -> Scene:
    """The scene as a preview sees it: a quarter of the pixels."""
    return scene.with_camera(scene.camera.reduced(2))


def doubled(image: NDArray[np.float32], width: int, height: int) -> NDArray[np.float32]:
    """(height, width, c) pixels between those of (ceil(height / 2), ceil(width / 2), c)."""
    near, far = np.float32(0.75), np.float32(0.25)
    for axis, size in ((0, height), (1, width)):
        rows = np.moveaxis(image, axis, 0)
        before, after = np.concatenate([rows[:1], rows[:-1]]), np.concatenate([rows[1:], rows[-1:]])
        both: NDArray[np.float32] = np.stack(
            [near * rows + far * before, near * rows + far * after], axis=1
        )
        image = np.moveaxis(both.reshape(-1, *rows.shape[1:])[:size], 0, axis)
    return np.ascontiguousarray(image)


def preview_settings(scene: Scene, method: str, settings: Any) -> Any:
    """Those of a preview; None where the whole product does not take long, or none is quicker."""
    if method not in PREVIEWS or seconds(scene, settings) <= LONG:
        return None
    lower = {
        name: most for name, most in PREVIEWS[method].items() if getattr(settings, name) > most
    }
    return replace(settings, **lower) if lower else None


def seconds(scene: Scene, settings: Any) -> float:
    """About what a product of a fixed view takes on this machine."""
    pixels = scene.camera.width * scene.camera.height
    of_sample = settings.bounce_rays + LIGHTS  # which tell the importance of wavelets
    rays = settings.gather_samples * of_sample + pixels * settings.view_rays
    return float(rays / (RATE * thread_count()))
