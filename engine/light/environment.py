"""Light from infinity: a latitude-longitude map around the scene, importance-sampled.

Row 0 of the map looks up (+y), its middle column along -z, and columns run so that the map, seen
from inside, reads from left to right: u = 1/2 + atan2(x, -z) / 2π for direction (x, y, z). The
rotation turns the map counter-clockwise about +y as seen from above: by 90 degrees, and what stood
at -z stands at -x. An area light (`far_disk`) may shine before the map.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Annotated, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray
from pydantic import Field

from engine.light.far_disk import NO_DISK, Disk, FarDisk, disk_of, on_disk, sample_disk
from engine.light.sky import Sky
from engine.numerics.description import Description, Finite, NonNegative, Radiance


class EnvironmentDescription(Description):
    """`map` is a file, the name of a built-in map, a constant radiance, or a clear sky.

    Files hold latitude-longitude maps or cube maps (`engine.light.cube_file`).

    Without `background` the camera sees black where it meets nothing; the light is the same.
    """

    map: Annotated[
        str | Radiance | Sky,
        Field(description="a file (.exr, .hdr, .png, .jpg), 'studio', a radiance, or a sky"),
    ] = (1.0, 1.0, 1.0)
    rotation_degrees: Finite = 0.0
    intensity: Annotated[
        NonNegative, Field(description="factor on the radiance of map and area light")
    ] = 1.0
    area_light: FarDisk | None = None
    background: Annotated[bool, Field(description="whether the camera sees it")] = True


class EnvironmentTable(NamedTuple):
    """An environment as kernels want it; a table with `present` False is black.

    present      bool
    radiance     (h, w, 3) float32   intensity included
    cos_r sin_r  float               rotation
    rows         (h + 1,) float64    cumulative probability of the map's rows
    columns      (h, w + 1) float64  cumulative probability of the pixels of each row
    disk         Disk                the area light, as turned as the map
    seen         bool                whether the camera sees any of it
    """

    present: bool
    radiance: NDArray[np.float32]
    cos_r: float
    sin_r: float
    rows: NDArray[np.float64]
    columns: NDArray[np.float64]
    disk: Disk
    seen: bool


@dataclass(frozen=True, eq=False)
class Environment:
    """A description with its map, (h, w, 3) float32 linear radiance before the intensity."""

    description: EnvironmentDescription
    radiance: NDArray[np.float32]

    @cached_property
    def table(self) -> EnvironmentTable:
        """For the kernels."""
        return environment_table(self)

    @property
    def disk(self) -> Disk:
        """Its area light, as turned as the map."""
        d = self.description
        light = d.area_light
        return NO_DISK if light is None else disk_of(light, d.rotation_degrees, d.intensity)


def is_same(a: Environment | None, b: Environment | None) -> bool:
    """Whether both shine alike: the same map under equal descriptions."""
    if a is None or b is None:
        return a is b
    return a.radiance is b.radiance and a.description == b.description


def environment_table(environment: Environment | None) -> EnvironmentTable:
    """Pack an environment, or its absence, for the kernels."""
    if environment is None:
        one = np.zeros((1, 1, 3), np.float32)
        ends = np.array([0.0, 1.0])
        return EnvironmentTable(False, one, 1.0, 0.0, ends, ends[None].copy(), NO_DISK, False)
    angle = math.radians(environment.description.rotation_degrees)
    radiance = environment.radiance * np.float32(environment.description.intensity)
    height, width = radiance.shape[:2]
    # A pixel's probability is its brightness times its solid angle, which shrinks at the poles.
    edges = np.cos(np.linspace(0, np.pi, height + 1))
    weight = radiance.mean(axis=2, dtype=np.float64) * (edges[:-1] - edges[1:])[:, None]
    flux = float(weight.sum()) * 2 * math.pi / width
    weight += 1e-6 * weight.mean() + 1e-30
    columns = np.zeros((height, width + 1))
    columns[:, 1:] = np.cumsum(weight, axis=1)
    rows = np.concatenate([[0.0], np.cumsum(columns[:, -1])])
    columns /= columns[:, -1:]
    rows /= rows[-1]
    # The area light gets as many of the samples as it brings of the light.
    disk = environment.disk
    own = 2 * math.pi * disk.versine * sum(disk.radiance) / 3
    disk = disk._replace(share=own / (own + flux) if own > 0 else 0.0)
    seen = environment.description.background
    return EnvironmentTable(
        True, np.ascontiguousarray(radiance), math.cos(angle), math.sin(angle), rows, columns,
        disk, seen,
    )  # fmt: skip


@njit
def _to_map(table, d):
    return (
        table.cos_r * d[0] - table.sin_r * d[2],
        d[1],
        table.sin_r * d[0] + table.cos_r * d[2],
    )


@njit
def _pixel(table, d):
    """(row, column) that direction d falls on."""
    height, width = table.radiance.shape[:2]
    x, y, z = _to_map(table, d)
    u = 0.5 + math.atan2(x, -z) / (2.0 * math.pi)
    v = math.acos(max(-1.0, min(1.0, y))) / math.pi
    return min(int(v * height), height - 1), min(int(u * width), width - 1)


@njit
def radiance(table, d):
    """Radiance that arrives from direction d (unit, leaving the scene), piecewise constant."""
    if not table.present:
        return (0.0, 0.0, 0.0)
    i, j = _pixel(table, d)
    disk = table.disk
    over = 1.0 if disk.share > 0.0 and on_disk(disk, d) else 0.0
    return (
        table.radiance[i, j, 0] + over * disk.radiance[0],
        table.radiance[i, j, 1] + over * disk.radiance[1],
        table.radiance[i, j, 2] + over * disk.radiance[2],
    )


@njit
def pdf(table, d):
    """Density of `sample` over solid angle."""
    if not table.present:
        return 0.0
    i, j = _pixel(table, d)
    height, width = table.radiance.shape[:2]
    probability = (table.rows[i + 1] - table.rows[i]) * (
        table.columns[i, j + 1] - table.columns[i, j]
    )
    band = math.cos(math.pi * i / height) - math.cos(math.pi * (i + 1) / height)
    density = probability / (band * 2.0 * math.pi / width)
    disk = table.disk
    if disk.share > 0.0:
        density *= 1.0 - disk.share
        if on_disk(disk, d):
            density += disk.share / (2.0 * math.pi * disk.versine)
    return density


@njit
def sample(table, u1, u2):
    """A unit direction with density `pdf`, uniform within its pixel or the area light."""
    height, width = table.radiance.shape[:2]
    share = table.disk.share
    if u1 < share:
        return sample_disk(table.disk, u1 / share, u2)
    u1 = (u1 - share) / (1.0 - share)
    i = min(np.searchsorted(table.rows, u1, side="right") - 1, height - 1)
    u1 = (u1 - table.rows[i]) / (table.rows[i + 1] - table.rows[i])
    j = min(np.searchsorted(table.columns[i], u2, side="right") - 1, width - 1)
    u2 = (u2 - table.columns[i, j]) / (table.columns[i, j + 1] - table.columns[i, j])
    top, bottom = math.cos(math.pi * i / height), math.cos(math.pi * (i + 1) / height)
    y = top + u1 * (bottom - top)
    r = math.sqrt(max(0.0, 1.0 - y * y))
    phi = 2.0 * math.pi * ((j + u2) / width - 0.5)
    x, z = r * math.sin(phi), -r * math.cos(phi)
    return (
        table.cos_r * x + table.sin_r * z,
        y,
        -table.sin_r * x + table.cos_r * z,
    )
