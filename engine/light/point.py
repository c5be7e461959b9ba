"""A point that shines equally in all directions; `intensity` is radiant intensity, W·sr⁻¹."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light.base import INTENSITY, POSITION, ROW, Light
from engine.numerics.description import Point


class PointLight(Light):
    """A point that shines in all directions; intensity in W·sr⁻¹."""

    type: Literal["point"] = "point"
    position: Point

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`."""
        row = np.zeros(ROW, np.float32)
        row[POSITION : POSITION + 3] = self.position
        row[INTENSITY : INTENSITY + 3] = self.intensity
        return row


@njit
def illuminate(p, x, u1, u2):
    """I / r²."""
    dx, dy, dz = p[0] - x[0], p[1] - x[1], p[2] - x[2]
    r2 = dx * dx + dy * dy + dz * dz
    if r2 < 1e-20:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    r = math.sqrt(r2)
    return (dx / r, dy / r, dz / r, r, p[6] / r2, p[7] / r2, p[8] / r2)


@njit
def pdf(p, x, w):
    """No extent."""
    return 0.0


@njit
def emitted(p, o, d):
    """No extent."""
    return (-1.0, 0.0, 0.0, 0.0)
