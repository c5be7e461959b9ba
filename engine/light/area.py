"""A rectangle that shines from one side; `intensity` is its radiance, W·sr⁻¹·m⁻².

Every point of the side that the normal leaves emits the same radiance in every direction. The
lamp is no part of the geometry: it casts no shadow and reflects nothing.
"""

from __future__ import annotations

import math
from typing import Annotated, ClassVar, Literal

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.light.base import DIRECTION, EXTRA, INTENSITY, POSITION, ROW, Light, unit
from engine.numerics.description import Point

Size = Annotated[float, Field(ge=1e-4, le=1e6)]


class AreaLight(Light):
    """A one-sided rectangular lamp."""

    type: Literal["area"] = "area"
    position: Annotated[Point, Field(description="its centre")]
    target: Annotated[Point, Field(description="a point straight in front of it")]
    up: Annotated[
        Point,
        Field(description="where its height runs; along z if this is parallel to the normal"),
    ] = (0.0, 1.0, 0.0)
    width: Annotated[Size, Field(description="metres, across up")] = 1.0
    height: Annotated[Size, Field(description="metres, along up")] = 1.0

    has_extent: ClassVar[bool] = True

    @model_validator(mode="after")
    def _has_a_front(self) -> AreaLight:
        unit(np.subtract(self.target, self.position), "position and target are the same point")
        unit(np.asarray(self.up), "up is zero")
        return self

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`; then the unit vectors along width and height, half sizes, area."""
        normal = unit(np.subtract(self.target, self.position))
        across = np.cross(unit(np.asarray(self.up)), normal)
        if np.linalg.norm(across) < 1e-6:
            across = np.cross((0.0, 0.0, 1.0), normal)
            if np.linalg.norm(across) < 1e-6:  # up and normal both run along z
                across = np.array((1.0, 0.0, 0.0))
        across = unit(across)
        row = np.zeros(ROW, np.float32)
        row[POSITION : POSITION + 3] = self.position
        row[DIRECTION : DIRECTION + 3] = normal
        row[INTENSITY : INTENSITY + 3] = self.intensity
        row[EXTRA : EXTRA + 3] = across
        row[EXTRA + 3 : EXTRA + 6] = np.cross(normal, across)
        row[EXTRA + 6 : EXTRA + 9] = self.width / 2, self.height / 2, self.width * self.height
        return row


@njit
def illuminate(p, x, u1, u2):
    """Uniform over the area: L · area · cos θ_light / r²."""
    a, b = (2.0 * u1 - 1.0) * p[15], (2.0 * u2 - 1.0) * p[16]
    dx = p[0] + a * p[9] + b * p[12] - x[0]
    dy = p[1] + a * p[10] + b * p[13] - x[1]
    dz = p[2] + a * p[11] + b * p[14] - x[2]
    r2 = dx * dx + dy * dy + dz * dz
    if r2 < 1e-20:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    r = math.sqrt(r2)
    wx, wy, wz = dx / r, dy / r, dz / r
    cos_light = -(wx * p[3] + wy * p[4] + wz * p[5])
    k = max(0.0, cos_light) * p[17] / r2
    return (wx, wy, wz, r, p[6] * k, p[7] * k, p[8] * k)


@njit
def _hit(p, o, d):
    """(distance, cos θ_light) along a ray to the front of the rectangle; distance < 0: missed."""
    facing = -(d[0] * p[3] + d[1] * p[4] + d[2] * p[5])
    if facing <= 0.0:
        return -1.0, 0.0
    cx, cy, cz = o[0] - p[0], o[1] - p[1], o[2] - p[2]
    t = (cx * p[3] + cy * p[4] + cz * p[5]) / facing
    if t <= 0.0:
        return -1.0, 0.0
    hx, hy, hz = cx + t * d[0], cy + t * d[1], cz + t * d[2]
    if abs(hx * p[9] + hy * p[10] + hz * p[11]) > p[15]:
        return -1.0, 0.0
    if abs(hx * p[12] + hy * p[13] + hz * p[14]) > p[16]:
        return -1.0, 0.0
    return t, facing


@njit
def pdf(p, x, w):
    """r² / (area · cos θ_light)."""
    t, facing = _hit(p, x, w)
    if t <= 0.0:
        return 0.0
    return t * t / (p[17] * facing)


@njit
def emitted(p, o, d):
    """The radiance, where the ray meets the front."""
    t, _ = _hit(p, o, d)
    if t <= 0.0:
        return (-1.0, 0.0, 0.0, 0.0)
    return (t, float(p[6]), float(p[7]), float(p[8]))
