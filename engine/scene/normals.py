"""Shading normals for meshes that come without: smooth, but not across creases."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.scene.part import Part

CREASE_DEGREES = 40.0
WELD = 5e-7  # of the longest side of the bounds: rounding; so that 21 bits hold a coordinate
MAX_VALENCE = 512  # corners at one point; beyond that each triangle keeps its own normal


def with_normals(part: Part, crease_degrees: float = CREASE_DEGREES) -> Part:
    """The part with normals made: vertices at one place share one, split where a crease runs.

    A corner's normal is the mean of the triangles that meet at its place and turn away from its own
    triangle by less than `crease_degrees`, each weighed with its angle there (Thürmer and Wüthrich
    1998): independent of how a flat face is cut into triangles. With 180 there are no creases.
    """
    corners = part.positions[part.triangles]
    # Weld: vertices at the same place are one, whatever the file says, but for rounding.
    low, high = part.positions.min(axis=0), part.positions.max(axis=0)
    step = max(float(np.max(high - low)) * WELD, 1e-30)
    grid = np.rint((part.positions - low) / step).astype(np.int64)
    _, place = np.unique(grid @ [1 << 42, 1 << 21, 1], return_inverse=True)
    place = place.reshape(-1)[part.triangles].reshape(-1)
    order = np.argsort(place, kind="stable")
    starts = np.concatenate([[0], np.cumsum(np.bincount(place))])
    flat = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    length = np.linalg.norm(flat, axis=1, keepdims=True)
    flat = flat / np.where(length > 0, length, 1)
    normals = np.zeros((len(place), 3))
    _corner_normals(
        flat,
        _angles(corners).reshape(-1),
        place,
        order,
        starts,
        math.cos(math.radians(crease_degrees)),
        normals,
    )
    # One vertex for every different triple of place, texture coordinates and normal.
    old = part.triangles.reshape(-1)
    uv = np.zeros(len(old), np.int64)
    if part.uvs is not None:
        uv = np.unique(part.uvs, axis=0, return_inverse=True)[1].reshape(-1)[old]
    where = place * (int(uv.max()) + 1) + uv
    direction = np.rint(normals * 1e5).astype(np.int64) @ [1 << 40, 1 << 20, 1]
    order = np.lexsort((direction, where))
    new = np.ones(len(order), bool)
    new[1:] = (np.diff(where[order]) != 0) | (np.diff(direction[order]) != 0)
    index = np.zeros(len(order), np.int64)
    index[order] = np.cumsum(new) - 1
    first = order[new]
    old = old[first]
    return Part(
        part.positions[old],
        index.reshape(-1, 3),
        normals[first],
        None if part.uvs is None else part.uvs[old],
        part.material,
    )


def _angles(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """The angle at each corner, (t, 3), of triangles (t, 3, 3)."""
    a = np.roll(corners, -1, axis=1) - corners
    b = np.roll(corners, 1, axis=1) - corners
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=2), np.sum(a * b, axis=2))


@njit(cache=True, nogil=True)
def _corner_normals(flat, angle, place, order, starts, cos_crease, out):
    for corner in range(out.shape[0]):
        own = corner // 3
        first, last = starts[place[corner]], starts[place[corner] + 1]
        x = y = z = 0.0
        if last - first <= MAX_VALENCE:
            for k in range(first, last):
                other = order[k] // 3
                cosine = (
                    flat[own, 0] * flat[other, 0]
                    + flat[own, 1] * flat[other, 1]
                    + flat[own, 2] * flat[other, 2]
                )
                if cosine > cos_crease:
                    x += angle[order[k]] * flat[other, 0]
                    y += angle[order[k]] * flat[other, 1]
                    z += angle[order[k]] * flat[other, 2]
        length = math.sqrt(x * x + y * y + z * z)
        if length < 1e-12:
            x, y, z, length = flat[own, 0], flat[own, 1], flat[own, 2], 1.0
        out[corner, 0] = x / length
        out[corner, 1] = y / length
        out[corner, 2] = z / length
