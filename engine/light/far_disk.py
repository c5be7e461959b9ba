"""The area light of an environment: a disk of even radiance on the sphere of directions.

A disk of radius ρ fills the solid angle 2π (1 - cos ρ), and gives a surface that faces it the
irradiance π L sin²ρ. It belongs to the environment: the rotation turns it, the intensity is a
factor on it, and its light adds to that of the map behind it.
"""

from __future__ import annotations

import math
from typing import Annotated, NamedTuple

from numba import njit
from pydantic import Field, model_validator

from engine.light.base import unit
from engine.numerics.description import Description, Point, Radiance
from engine.numerics.frames import tangents, to_world
from engine.numerics.sampling import uniform_cone
from engine.numerics.vec import Vec


class FarDisk(Description):
    """An area light at infinity; its radiance is that of the map's unit."""

    direction: Annotated[
        Point, Field(description="where its light travels, of any length, on a map not turned")
    ]
    radius_degrees: Annotated[float, Field(ge=0.25, le=45)] = 10.0
    radiance: Radiance = (10.0, 10.0, 10.0)

    @model_validator(mode="after")
    def _has_direction(self) -> FarDisk:
        unit(self.direction, "direction is zero")
        return self


class Disk(NamedTuple):
    """A disk as it shines, for kernels; where there is none the share is 0.

    axis      unit, towards its middle
    versine   1 - cos of its radius
    radiance  intensity included
    share     of samples of the environment that go there
    """

    axis: Vec
    versine: float
    radiance: Vec
    share: float


NO_DISK = Disk((0.0, 1.0, 0.0), 0.0, (0.0, 0.0, 0.0), 0.0)


def disk_of(light: FarDisk, rotation_degrees: float, intensity: float) -> Disk:
    """The disk in a turned environment; the share is left at 0."""
    x, y, z = unit(light.direction)
    angle = math.radians(rotation_degrees % 360.0)
    c, s = math.cos(angle), math.sin(angle)
    red, green, blue = light.radiance
    return Disk(
        (-(c * x + s * z), -y, s * x - c * z),
        2 * math.sin(math.radians(light.radius_degrees) / 2) ** 2,
        (intensity * red, intensity * green, intensity * blue),
        0.0,
    )


def radius_of(disk: Disk) -> float:
    """Radians."""
    return 2 * math.asin(math.sqrt(disk.versine / 2))


@njit
def on_disk(disk, d):
    """Whether unit d points at it: 1 - cos is half the squared distance of unit vectors."""
    x, y, z = disk.axis[0] - d[0], disk.axis[1] - d[1], disk.axis[2] - d[2]
    return 0.5 * (x * x + y * y + z * z) <= disk.versine


@njit
def sample_disk(disk, u1, u2):
    """A unit direction in it, uniform over its solid angle 2π versine."""
    s, t = tangents(disk.axis)
    return to_world(uniform_cone(u1, u2, disk.versine), s, t, disk.axis)
