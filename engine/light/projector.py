"""An image thrown into the scene; `intensity` is the radiant intensity of its white, W·sr⁻¹.

The image stands upright and unmirrored on a wall in front of the projector. On a wall at right
angles to the axis it keeps its proportions and its brightnesses, as a projector's lens sees to:
at z metres along the axis the irradiance is I T / z², with T the image there. That takes a radiant
intensity of I T / cos³θ, and the lamp emits I · mean(T) · 4 tan(fov_x / 2) tan(fov_y / 2) watts.

Where a pixel of the image is smaller than the piece of surface that is lit, the image is looked up
at a smaller size, so that fine detail fades out and does not flicker.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal, Self

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field, PrivateAttr, model_validator

from engine.errors import SceneError
from engine.light.base import (
    EXTRA,
    IMAGE,
    Light,
    across,
    no_formula,
    no_pdf,
    nothing_emitted,
    towards,
    unit,
)
from engine.light.pyramid import BUILT_IN, Pyramid, load_image, look_up
from engine.numerics.description import Point


class ProjectorLight(Light):
    """A point that throws an image; intensity of its white, straight ahead, in W·sr⁻¹."""

    type: Literal["projector"] = "projector"
    position: Point
    target: Annotated[Point, Field(description="where the middle of the image falls")]
    up: Annotated[
        Point,
        Field(description="where the image is upright; along z if this is along the axis"),
    ] = (0.0, 1.0, 0.0)
    fov_y_degrees: Annotated[
        float, Field(ge=0.1, le=170, description="from the lower to the upper border")
    ] = 40.0
    image: Annotated[
        str,
        Field(
            min_length=1,
            max_length=1024,
            description="a file beside the scene (.png, .jpg, .exr, .hdr), or "
            + ", ".join(repr(name) for name in BUILT_IN),
        ),
    ] = "window"

    _pyramid: Pyramid | None = PrivateAttr(None)

    @model_validator(mode="after")
    def _has_an_axis(self) -> ProjectorLight:
        towards(self.position, self.target)
        unit(self.up, "up is zero")
        return self

    def located(self, folder: Path) -> Self:
        """See `Light.located`."""
        try:
            pyramid = load_image(self.image, folder)
        except SceneError as error:
            raise SceneError(error.message, field="image", file=error.file) from None
        light = self.model_copy()
        light._pyramid = pyramid
        return light

    def pyramid(self) -> Pyramid:
        """The image; one that `located` has not read is looked for where the process runs."""
        return self._pyramid or load_image(self.image, Path())

    def row(self) -> NDArray[np.float32]:
        """See `Light.row`; then unit vectors to the image's left and up, the tangents of half its
        width and height, and a pixel's width at unit distance.
        """
        axis, image = towards(self.position, self.target), self.pyramid()
        tangent = math.tan(math.radians(self.fov_y_degrees) / 2)
        row = self.start(self.position, axis)
        row[EXTRA : EXTRA + 3], row[EXTRA + 3 : EXTRA + 6] = across(axis, self.up)
        row[EXTRA + 6 : EXTRA + 8] = tangent * image.width / image.height, tangent
        row[EXTRA + 8] = 2 * tangent / image.height
        return row


@njit
def illuminate(p, texels, x, size, u1, u2):
    """I T / (r² cos³θ) inside the image, 0 outside."""
    dx, dy, dz = x[0] - p[0], x[1] - p[1], x[2] - p[2]
    z = dx * p[3] + dy * p[4] + dz * p[5]
    r2 = dx * dx + dy * dy + dz * dz
    if z <= 0.0 or r2 < 1e-20:
        return (0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0)
    r = math.sqrt(r2)
    wx, wy, wz = -dx / r, -dy / r, -dz / r
    u = 0.5 - 0.5 * (dx * p[9] + dy * p[10] + dz * p[11]) / (z * p[15])
    v = 0.5 - 0.5 * (dx * p[12] + dy * p[13] + dz * p[14]) / (z * p[16])
    if u < 0.0 or u > 1.0 or v < 0.0 or v > 1.0:
        return (wx, wy, wz, r, 0.0, 0.0, 0.0)
    wide = size / (z * p[17])
    lod = math.log2(wide) if wide > 1.0 else 0.0
    red, green, blue = look_up(texels, p[IMAGE], p[IMAGE + 1], p[IMAGE + 2], u, v, lod)
    k = r / (z * z * z)
    return (wx, wy, wz, r, p[6] * red * k, p[7] * green * k, p[8] * blue * k)


pdf, emitted = no_pdf, nothing_emitted
irradiance, glance = no_formula, illuminate
