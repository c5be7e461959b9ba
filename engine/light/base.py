"""The light contract.

A light shader is a small function of position and direction. A new one is one file and one line:
the file holds a `Light` subclass, its description in JSON, and five Numba kernels; the line names
both in `engine.light.table.LIGHTS`. From there it is in the schema, in edits, in every renderer and
on the page, whose handles follow the names of the fields (position, target, direction). The GPU
draws it by a shader of its name in `shaders/light`, see the README there.

    illuminate(p, texels, x, size, u1, u2) -> (wx, wy, wz, distance, r, g, b)
        One sample of the light as seen from world position x: unit direction towards it, distance
        to it (1e30 for a light at infinity), and the incident radiance divided by the density of
        the sample over solid angle. So `rgb · f · cos θ` is an unbiased estimate of the reflected
        radiance. `size` is the width of the piece of surface that x stands for, in metres, 0 for a
        point: detail below it may be averaged. Lights without extent ignore u1, u2 and return
        intensity / distance².
    pdf(p, x, w) -> float
        Density over solid angle with which `illuminate` takes direction w from x; 0 for lights
        without extent, which no ray can hit.
    emitted(p, o, d) -> (distance, r, g, b)
        What a ray from o along unit d sees of the light itself; distance < 0 where it misses.
    irradiance(p, x, n, g) -> (r, g, b)
        What a surface at x with unit normal n receives of a light with extent that nothing hides,
        the integral of radiance · cos θ over directions above both n and g, the normal of the flat
        triangle. Negative where there is no formula: then it is summed up from samples.
    glance(p, texels, x, size, u1, u2) -> as `illuminate`
        The same for what only asks how much of a light is hidden: quicker where it can be, and a
        sample may weigh any amount.

`p` is a row of ROW float32 numbers made by the description's `row()`. `texels` (k, 3) float32 holds
the images of all lights of a table: a light that has one returns it from `pyramid()` and finds in
p[IMAGE:] what `engine.light.pyramid.look_up` needs. Neighbours in (u1, u2) are neighbours on the
light, because soft shadows are made of a grid of them. No kernel returns NaN, even for x on the
light. Shadows are the caller's business.

A whole one, whose light does not fall off with distance:

    class Glow(Light):
        type: Literal["glow"] = "glow"
        position: Point

        def row(self) -> NDArray[np.float32]:
            return self.start(position=self.position)

    @njit
    def illuminate(p, texels, x, size, u1, u2):
        d = (p[0] - x[0], p[1] - x[1], p[2] - x[2])
        r = max(length(d), 1e-10)
        return (d[0] / r, d[1] / r, d[2] / r, r, float(p[6]), float(p[7]), float(p[8]))

    pdf, emitted = no_pdf, nothing_emitted
    irradiance, glance = no_formula, illuminate
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import ClassVar, Self

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from engine.light.pyramid import Pyramid
from engine.numerics.description import Description, Radiance
from engine.numerics.vec import Vec, cross

ROW = 32
POSITION, DIRECTION, INTENSITY, EXTRA = 0, 3, 6, 9
IMAGE = 29  # of a light with an image, see `light_table`
UNKNOWN, DARK = (-1.0, -1.0, -1.0), (0.0, 0.0, 0.0)  # of `irradiance`


class Light(Description):
    """What every light has, whatever its type."""

    id: str = Field(min_length=1, max_length=64, description="unique name within the scene")
    intensity: Radiance = Field(
        (1.0, 1.0, 1.0), description="linear RGB; its unit is the light's own, see there"
    )
    enabled: bool = True

    has_extent: ClassVar[bool] = False

    def row(self) -> NDArray[np.float32]:
        """(ROW,) float32 parameters for the kernels; every kind has its own."""
        raise NotImplementedError

    def start(
        self, position: Vec = (0.0, 0.0, 0.0), direction: Vec = (0.0, 0.0, 0.0)
    ) -> NDArray[np.float32]:
        """A row with what most kinds have, and zeros from EXTRA on."""
        row = np.zeros(ROW, np.float32)
        row[POSITION : POSITION + 3] = position
        row[DIRECTION : DIRECTION + 3] = direction
        row[INTENSITY : INTENSITY + 3] = self.intensity
        return row

    def pyramid(self) -> Pyramid | None:
        """The image that the kernels look up, if the kind has one."""
        return None

    def located(self, folder: Path) -> Self:
        """The light with the files that it names, which lie in `folder`, read.

        Raises SceneError, with the light's field and the file, where one cannot be read.
        """
        return self


def unit(v: Vec, problem: str = "a direction is zero") -> Vec:
    """v at unit length; ValueError, saying `problem`, where it has none."""
    length = math.hypot(*v)
    if length < 1e-9:
        raise ValueError(problem)
    return (v[0] / length, v[1] / length, v[2] / length)


def towards(position: Vec, target: Vec) -> Vec:
    """Unit direction from position to target; ValueError where they are the same."""
    x, y, z = (b - a for a, b in zip(position, target, strict=True))
    return unit((x, y, z), "position and target are the same point")


def across(axis: Vec, up: Vec) -> tuple[Vec, Vec]:
    """Unit vectors (s, t) across a unit axis: t is nearest to up, and s, t, axis right-handed.

    For an up along the axis the z axis stands in, and the y axis for it in turn.
    """
    for candidate in (unit(up, "up is zero"), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0)):
        s = cross.py_func(candidate, axis)
        if math.hypot(*s) > 1e-6:
            break
    s = unit(s)
    return s, cross.py_func(axis, s)


@njit
def no_pdf(p, x, w):
    """The `pdf` of a light without extent."""
    return 0.0


@njit
def nothing_emitted(p, o, d):
    """The `emitted` of a light without extent."""
    return (-1.0, 0.0, 0.0, 0.0)


@njit
def no_formula(p, x, n, g):
    """The `irradiance` of a light without extent, or of one that has to be sampled."""
    return UNKNOWN


@njit
def shares_plane(n, g):
    """Whether two unit normals are the same, within a tenth of a degree."""
    return n[0] * g[0] + n[1] * g[1] + n[2] * g[2] > 1.0 - 2e-6
