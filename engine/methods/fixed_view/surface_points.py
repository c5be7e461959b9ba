"""Points at given places on triangles, and what their surfaces reflect in all."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import hemispherical_albedo
from engine.brdf.base import ROW, without_grain
from engine.methods.fixed_view.frame_buffer import Points, no_points
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import scale
from engine.scene import surface
from engine.scene.scene import Scene

ALBEDO_POINTS = 256


def equivalent_albedo(points: Points) -> NDArray[np.float32]:
    """(n, 3) float32: hemispherical albedo of each point's whole BRDF, gloss included."""
    # An albedo is linear in the diffuse colour, so two per kind of gloss give it for any texture.
    kinds, kind = _kinds(np.column_stack([points.model, without_grain(points.row)[:, 3:]]))
    model = kinds[:, 0].astype(np.int32)
    row = np.zeros((len(kinds), ROW), np.float32)
    row[:, 3:] = kinds[:, 1:]
    black = hemispherical_albedo(model, row, ALBEDO_POINTS)
    row[:, :3] = 1
    white = hemispherical_albedo(model, row, ALBEDO_POINTS)
    diffuse = points.row[:, :3]
    return (black[kind] + diffuse * (white - black)[kind]).astype(np.float32)


def _kinds(rows: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.intp]]:
    """The different ones of rows (n, k), and which of them each is (n,).

    Most columns are constant, or nearly: that makes this a tenth of the work of sorting rows.
    """
    kind = np.zeros(len(rows), np.intp)
    for column in rows.T:
        if (column != column[:1]).any():
            values, number = np.unique(column, return_inverse=True)
            _, kind = np.unique(kind * len(values) + number, return_inverse=True)
    _, first, kind = np.unique(kind, return_index=True, return_inverse=True)
    return rows[first], kind


def describe(
    scene: Scene,
    triangle: NDArray[np.int32],
    back: NDArray[np.bool_],
    barycentric: NDArray[np.float32],
) -> Points:
    """Points (n) on the front or back of triangles (n,), seen along their normals."""
    n = len(triangle)
    points = no_points(n)
    for_ranges(
        _describe_samples, n, scene.geometry, scene.material_table, triangle, back, barycentric,
        points.position, points.normal, points.geometric, points.view, points.model, points.row,
        points.object, points.material,
    )  # fmt: skip
    return points


@njit(cache=True, nogil=True)
def _describe_samples(
    start, stop, geometry, materials, triangle, back, barycentric,
    position, normal, geometric, view, model, row, obj, material,
):  # fmt: skip
    for i in range(start, stop):
        t, b1, b2 = triangle[i], barycentric[i, 0], barycentric[i, 1]
        p = surface.position(geometry, t, b1, b2)
        g = surface.geometric_normal(geometry, t)
        if back[i]:
            g = scale(g, -1.0)
        _, s = surface.normals(geometry, materials, t, b1, b2, g)
        model[i] = surface.parameters(geometry, materials, t, b1, b2, s, row[i])
        obj[i] = geometry.object[t]
        material[i] = geometry.material[t]
        for k in range(3):
            position[i, k] = p[k]
            normal[i, k] = s[k]
            geometric[i, k] = g[k]
            view[i, k] = s[k]
