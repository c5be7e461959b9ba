"""The pinhole camera."""

from __future__ import annotations

import math
from typing import Annotated, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.numerics.description import Description, Point

MAX_PIXELS = 4096 * 4096

# Offsets of the four sub-samples of a pixel from its centre, in pixels.
SUBSAMPLES = np.array([[-0.25, -0.25], [0.25, -0.25], [-0.25, 0.25], [0.25, 0.25]])


class Camera(Description):
    """Position, target and up in world space; the vertical field of view in degrees; pixels."""

    position: Point
    target: Point
    up: Point = (0.0, 1.0, 0.0)
    fov_y_degrees: Annotated[float, Field(gt=0.1, lt=170)] = 40.0
    width: Annotated[int, Field(ge=1, le=16384)] = 640
    height: Annotated[int, Field(ge=1, le=16384)] = 480

    @model_validator(mode="after")
    def _has_directions(self) -> Camera:
        forward = np.subtract(self.target, self.position)
        if np.linalg.norm(forward) == 0:
            raise ValueError("position and target are the same point")
        if np.linalg.norm(np.cross(forward, self.up)) == 0:
            raise ValueError("up is zero or parallel to the viewing direction")
        if self.width * self.height > MAX_PIXELS:
            raise ValueError(
                f"{self.width} x {self.height} pixels are more than {MAX_PIXELS}; "
                "render a smaller picture or render it in parts"
            )
        return self

    def basis(self) -> NDArray[np.float64]:
        """(3, 3): rows are right, up, backward; unit length, right-handed."""
        back = np.subtract(self.position, self.target).astype(np.float64)
        back /= np.linalg.norm(back)
        right = np.cross(self.up, back)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(back, right), back])

    def shape(self, step: int = 1) -> tuple[int, int]:
        """(height, width) of the picture of every step-th pixel of every step-th row."""
        return -(-self.height // step), -(-self.width // step)

    def reduced(self, step: int) -> Self:
        """The camera of a picture of its own with so many pixels."""
        height, width = self.shape(step)
        return self.model_copy(update={"width": width, "height": height})

    @property
    def spread(self) -> float:
        """Width of a pixel at unit distance."""
        return 2 * math.tan(math.radians(self.fov_y_degrees) / 2) / self.height

    def to_pixels(self, step: int = 1) -> NDArray[np.float64]:
        """(3, 3): takes a direction from the eye to (x d, y d, d).

        Column x and row y of that picture, pixel centres at whole numbers, and depth d in metres.
        """
        right, up, back = self.basis()
        size = 0.5 * np.array([self.width, self.height])
        scale = size[1] / math.tan(math.radians(self.fov_y_degrees) / 2)
        return np.stack([
            (scale * right - (size[0] - 0.5) * back) / step,
            (-scale * up - (size[1] - 0.5) * back) / step,
            -back,
        ])  # fmt: skip

    def directions(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float32]:
        """Unit directions (n, 3) float32 through pixel coordinates.

        x (n,) runs from 0 at the left edge to width, y (n,) from 0 at the top edge to height;
        pixel centres are at half-integers.
        """
        half = math.tan(math.radians(self.fov_y_degrees) / 2)
        right, up, back = self.basis()
        sx = (2 * np.asarray(x, np.float64) / self.width - 1) * half * self.width / self.height
        sy = (1 - 2 * np.asarray(y, np.float64) / self.height) * half
        d = sx[:, None] * right + sy[:, None] * up - back
        d /= np.linalg.norm(d, axis=1, keepdims=True)
        return d.astype(np.float32)


class SparseCamera(Camera):
    """A picture of every stride-th pixel of every stride-th row of a whole one.

    Its pixels are as small as those of the whole picture, and see what those see: a few of them
    tell what it is like. Neighbours lie apart, so what joins them joins what it should not.
    """

    stride: int
    whole_width: int
    whole_height: int

    @property
    def whole(self) -> Camera:
        """The camera of the whole picture."""
        kept = self.model_dump(exclude={"stride", "whole_width", "whole_height"})
        return Camera(**{**kept, "width": self.whole_width, "height": self.whole_height})

    @property
    def spread(self) -> float:
        """As that of the whole picture."""
        return self.whole.spread

    def to_pixels(self, step: int = 1) -> NDArray[np.float64]:
        """See `Camera.to_pixels`."""
        return self.whole.to_pixels(self.stride * step)

    def directions(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float32]:
        """See `Camera.directions`; a pixel's coordinates are those within its small self."""
        return self.whole.directions(*(self._within(np.asarray(a, np.float64)) for a in (x, y)))

    def _within(self, at: NDArray[np.float64]) -> NDArray[np.float64]:
        pixel = np.floor(at)
        return self.stride * pixel + (at - pixel)


def sparse(camera: Camera, stride: int) -> Camera:
    """The camera that sees every stride-th pixel of every stride-th row; itself for 1."""
    if stride == 1:
        return camera
    height, width = camera.shape(stride)
    return SparseCamera(
        **{**camera.model_dump(), "width": width, "height": height},
        stride=stride,
        whole_width=camera.width,
        whole_height=camera.height,
    )
