"""A scene as the reference's kernels want it: one tuple of arrays."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light.environment import EnvironmentTable, environment_table
from engine.light.table import LightTable, light_table
from engine.numerics.sampling import uniform_triangle
from engine.numerics.vec import vec
from engine.scene.scene import Geometry, MaterialTable, Scene


class EmitterTable(NamedTuple):
    """Triangles that shine by their material's emission, on both sides.

    triangle    (e,) int32     index into the geometry's triangles
    cumulative  (e,) float64   sums of area × (r + g + b), the last one is `total`
    total       float          0 where nothing shines
    """

    triangle: NDArray[np.int32]
    cumulative: NDArray[np.float64]
    total: float


class World(NamedTuple):
    """Everything a path meets; `epsilon` is how far rays start off a surface, metres."""

    geometry: Geometry
    materials: MaterialTable
    lights: LightTable
    environment: EnvironmentTable
    emitters: EmitterTable
    epsilon: float


def world(scene: Scene) -> World:
    """Pack a scene."""
    return World(
        scene.geometry,
        scene.material_table,
        light_table(scene.lights),
        environment_table(scene.environment),
        _emitters(scene.geometry, scene.material_table),
        scene.rays.epsilon,
    )


def _emitters(geometry: Geometry, materials: MaterialTable) -> EmitterTable:
    brightness = materials.emission.astype(np.float64).sum(axis=1)[geometry.material]
    corners = geometry.positions[geometry.triangles].astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    power = brightness * np.linalg.norm(normal, axis=1) / 2
    shining = np.flatnonzero(power > 0)
    cumulative = np.cumsum(power[shining])
    total = float(cumulative[-1]) if len(shining) else 0.0
    return EmitterTable(shining.astype(np.int32), cumulative, total)


@njit
def emission(geometry, materials, triangle):
    """Radiance that a triangle emits in every direction."""
    return vec(materials.emission, geometry.material[triangle])


@njit
def emitter_point(table, u0, u1, u2):
    """(triangle, b1, b2): a point on the emitters, its density ∝ r + g + b of the emission."""
    last = table.cumulative.shape[0] - 1
    k = min(np.searchsorted(table.cumulative, u0 * table.total, side="right"), last)
    b1, b2 = uniform_triangle(u1, u2)
    return table.triangle[k], b1, b2


@njit
def emitter_pdf(table, emission, distance, cosine):
    """Density of `emitter_point` over solid angle, seen from `distance` at |cos θ| of the light."""
    if table.total <= 0.0 or cosine <= 0.0:
        return 0.0
    return (emission[0] + emission[1] + emission[2]) / table.total * distance * distance / cosine
