"""A point that shines equally in all directions; `intensity` is radiant intensity, W·sr⁻¹."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light.base import Light, no_formula, no_pdf, nothing_emitted
from engine.numerics.description import Point


class PointLight(Light):
    """A point that shines in all directions; intensity in W·sr⁻¹."""

    type: Literal["point"] = "point"
    position: Point

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`."""
        return self.start(self.position)


@njit
def illuminate(p, texels, x, size, u1, u2):
    """I / r²."""
    dx, dy, dz = p[0] - x[0], p[1] - x[1], p[2] - x[2]
    r2 = dx * dx + dy * dy + dz * dz
    if r2 < 1e-20:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    r = math.sqrt(r2)
    return (dx / r, dy / r, dz / r, r, p[6] / r2, p[7] / r2, p[8] / r2)


pdf, emitted = no_pdf, nothing_emitted
irradiance, glance = no_formula, illuminate
