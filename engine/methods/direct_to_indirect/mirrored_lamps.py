"""How far off the mirror images of lamps are, which a frame takes as a few of their points."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from engine.diagnosis import Diagnosis
from engine.light.base import Light
from engine.methods.direct_to_indirect.gloss_limits import NEGLIGIBLE
from engine.methods.fixed_view.direct import POINTS_ON_GLOSS, light_from_each
from engine.methods.fixed_view.view import View

PIXELS = 64  # with gloss that are looked at


class MirroredLamps:
    """What each of some glossy pixels reflects of every point of a lamp.

    In full light a pixel takes eight of its 64 points. How much eight others would have made tells
    what is off: nothing where the lobe is wider than the lamp, all of it where it is narrower than
    the points lie apart.
    """

    def __init__(self, view: View, glossy: NDArray[np.bool_]) -> None:
        """glossy (pixels,) bool marks view samples whose gloss has rows of its own."""
        pixel = np.flatnonzero(glossy)
        self._view, self._part = view, len(pixel) / max(1, len(glossy))
        self._points = view.buffer.centre.take(pixel[:: max(1, len(pixel) // PIXELS)])

    def __call__(
        self, lights: tuple[Light, ...], image: NDArray[np.float32], scale: int
    ) -> Diagnosis | None:
        """What to say of the mirror images of lights in a picture (n, 3) of a scale, or None."""
        wide = [light for light in lights if light.enabled and light.has_extent]
        if not wide or not len(self._points):
            return None
        off = 0.0
        for light in wide:
            each = light_from_each(self._view.scene.rays, self._points, light)
            eights = each.reshape(len(each), -1, POINTS_ON_GLOSS, 3).mean(axis=2, dtype=np.float64)
            off += float(eights.var(axis=1, ddof=1).mean())
        off *= self._part
        if off <= 0:
            return None
        counted = np.ones(len(image), np.bool_)
        counted[self._view.lamp_pixels(wide, scale)] = False
        seen = image[counted].astype(np.float64)
        # What is drawn is off by as much already: that is not to be a part of itself.
        light_of_picture = float((seen**2).mean()) if len(seen) else 0.0
        size = math.sqrt(off / max(light_of_picture - off, off / 25))
        if size <= NEGLIGIBLE:
            return None
        return Diagnosis(
            "lamp_seen_as_points",
            f"Gloss mirrors a lamp so sharply that the {POINTS_ON_GLOSS} points show that a pixel "
            f"takes it as: {100 * size:.0f} % of the picture is off by that. No setting mends it; "
            "a smaller lamp or a wider lobe does, and the reference has whole lamps.",
            size,
        )
