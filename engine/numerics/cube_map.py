"""The sphere as the six faces of a cube, each in quad-tree order.

Faces are +X -X +Y -Y +Z -Z, oriented as in OpenGL. A cube map of n x n texels a face is an array of
6 n² rows, n a power of two: face by face, and within a face by Morton code (x in the lower bits),
so that each face is what `engine.numerics.haar` transforms, and the four texels that a texel of
half the resolution covers are neighbours in the array.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit
from numpy.typing import NDArray

FACES = 6

# Face by face: the direction of (x, y) in [-1, 1] is x · RIGHT + y · DOWN + AHEAD.
AHEAD = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], float)
RIGHT = np.array([[0, 0, -1], [0, 0, 1], [1, 0, 0], [1, 0, 0], [1, 0, 0], [-1, 0, 0]], float)
DOWN = np.array([[0, -1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1], [0, -1, 0], [0, -1, 0]], float)


@njit
def morton(x, y):
    """Place of texel (x, y) of a face in quad-tree order; both below 2^16."""
    code = 0
    for bit in range(16):
        code |= (x >> bit & 1) << 2 * bit | (y >> bit & 1) << 2 * bit + 1
    return code


@cache
def coordinates(n: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """(x, y) of the n² texels of a face in their order."""
    number = np.arange(n * n)
    x, y = np.zeros_like(number), np.zeros_like(number)
    for bit in range(n.bit_length() - 1):
        x |= (number >> 2 * bit & 1) << bit
        y |= (number >> 2 * bit + 1 & 1) << bit
    return x, y


def _on_faces(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit directions (6, q, 3) of places (q,) in [-1, 1], which may lie beyond the edges."""
    w = x[:, None] * RIGHT[:, None] + y[:, None] * DOWN[:, None] + AHEAD[:, None]
    return w / np.linalg.norm(w, axis=2, keepdims=True)


@cache
def directions(n: int) -> NDArray[np.float64]:
    """(6 n², 3): unit directions through the texels' centres."""
    x, y = coordinates(n)
    return _on_faces((2 * x + 1) / n - 1, (2 * y + 1) / n - 1).reshape(-1, 3)


@cache
def solid_angles(n: int) -> NDArray[np.float64]:
    """(6 n²,): of the texels, steradians; exact."""
    edge = np.linspace(-1, 1, n + 1)
    corner = np.arctan2(edge[:, None] * edge, np.sqrt(1 + edge[:, None] ** 2 + edge**2))
    x, y = coordinates(n)
    angle = corner[y + 1, x + 1] - corner[y, x + 1] - corner[y + 1, x] + corner[y, x]
    return np.tile(angle, FACES)


@cache
def vector_areas(n: int) -> NDArray[np.float64]:
    """(6 n², 3): ∫ ω dω over every texel; exact.

    Times a normal that has the whole texel above its horizon it is the projected solid angle: half
    the sum over the edges of a spherical polygon of their lengths times the normals of their planes
    (Lambert).
    """
    x, y = coordinates(n)
    low, high = (2 * np.stack([x, y]) / n - 1), (2 * (np.stack([x, y]) + 1) / n - 1)
    corners = [(low[0], low[1]), (high[0], low[1]), (high[0], high[1]), (low[0], high[1])]
    v = [_on_faces(*corner) for corner in corners]
    total = np.zeros_like(v[0])
    for k in range(4):
        across = np.cross(v[k], v[(k + 1) % 4])
        sine = np.linalg.norm(across, axis=2, keepdims=True)
        total -= np.arcsin(np.minimum(sine, 1)) / sine * across / 2
    # (The corners run clockwise, seen from the middle, on all faces.)
    return total.reshape(-1, 3)


@njit
def place(d):
    """(face, x, y) of a direction, x and y in [-1, 1]."""
    a, b, c = abs(d[0]), abs(d[1]), abs(d[2])
    if a >= b and a >= c:
        return (0, -d[2] / a, -d[1] / a) if d[0] > 0.0 else (1, d[2] / a, -d[1] / a)
    if b >= c:
        return (2, d[0] / b, d[2] / b) if d[1] > 0.0 else (3, d[0] / b, -d[2] / b)
    return (4, d[0] / c, -d[1] / c) if d[2] > 0.0 else (5, -d[0] / c, -d[1] / c)


@njit
def texel(d, n):
    """Number of the texel that a direction falls on."""
    face, x, y = place(d)
    i, j = min(n - 1, int(0.5 * (x + 1.0) * n)), min(n - 1, int(0.5 * (y + 1.0) * n))
    return face * n * n + morton(i, j)


@cache
def neighbours(n: int) -> NDArray[np.int32]:
    """(6 n², 8): the texels around each, over the edges too; at corners some come twice."""
    x, y = coordinates(n)
    found = np.zeros((FACES * n * n, 8), np.int32)
    k = 0
    for dy in (-1, 0, 1):
        for dx in (-1, 0, 1):
            if dx == dy == 0:
                continue
            w = _on_faces((2 * (x + dx) + 1) / n - 1, (2 * (y + dy) + 1) / n - 1)
            _texels_of(w.reshape(-1, 3), n, found[:, k])
            k += 1
    return found


@njit(cache=True, nogil=True)
def _texels_of(w, n, out):
    for i in range(w.shape[0]):
        out[i] = texel((w[i, 0], w[i, 1], w[i, 2]), n)
