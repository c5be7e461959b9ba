"""Where transport is stored: a vertex of the scene for each material that meets there."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.base import GRAIN
from engine.numerics.frames import tangents
from engine.numerics.vec import add, cross, dot, normalize, scale, sub, vec
from engine.scene.scene import Scene

LIFT = 4.0  # of the ray tracer's epsilon: vertices have no one plane that they could be moved off
INWARD = 0.5  # of the way to the middle of a triangle
ALIKE = 0.7  # cosine: frames at the corners of a triangle that are turned by less are one field
CLUSTER = 256  # most vertices of a cluster
TURNED = 1 / 6  # of a surface's size: what a radian between normals counts like


class Vertices(NamedTuple):
    """Sorted by material, and for each by cluster: vertices near each other that face alike.

    position  (v, 3) float32   metres
    eye       (v, 3) float32   from where its surroundings are looked at: where the vertex lies at
                               the rim of its surface, a little further in
    normal    (v, 3) float32   unit, for shading
    tangent   (v, 3) float32   unit, x axis of the local frame; along the grain of a brushed surface
    material  (v,) int32
    cluster   (s + 1,) int32   where the clusters begin, and the end
    corners   (t, 3) int32     vertices of the scene's triangles
    smooth    (t,) bool        whether the frames at the three corners are much the same
    """

    position: NDArray[np.float32]
    eye: NDArray[np.float32]
    normal: NDArray[np.float32]
    tangent: NDArray[np.float32]
    material: NDArray[np.int32]
    cluster: NDArray[np.int32]
    corners: NDArray[np.int32]
    smooth: NDArray[np.bool_]


def build_vertices(scene: Scene) -> Vertices:
    """The vertices that triangles use; others have no transport."""
    geometry = scene.geometry
    material = np.repeat(geometry.material, 3)
    used = np.stack([material.astype(np.int64), geometry.triangles.ravel()], axis=1)
    pairs, corner = np.unique(used, axis=0, return_inverse=True)
    order, cluster = _in_clusters(
        pairs[:, 0], geometry.positions[pairs[:, 1]], geometry.normals[pairs[:, 1]]
    )
    rank = np.zeros(len(order), np.int64)
    rank[order] = np.arange(len(order))
    pairs = pairs[order]
    corners = rank[corner.ravel()].reshape(-1, 3).astype(np.int32)
    normal = np.ascontiguousarray(geometry.normals[pairs[:, 1]])
    brushed = np.abs(scene.material_table.row[pairs[:, 0], GRAIN:]).sum(axis=1) > 0
    given = np.where(brushed[:, None], geometry.tangents[pairs[:, 1]], 0)
    tangent = np.zeros_like(normal)
    _frames(normal, given, tangent)
    smooth = np.zeros(len(corners), np.bool_)
    _compare(corners, tangent, smooth)
    position = np.ascontiguousarray(geometry.positions[pairs[:, 1]])
    return Vertices(
        position,
        _eyes(position, normal, corners, scene.rays.epsilon),
        normal,
        tangent,
        pairs[:, 0].astype(np.int32),
        cluster,
        corners,
        smooth,
    )


def _in_clusters(
    material: NDArray[np.int64], position: NDArray[np.float32], normal: NDArray[np.float32]
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """(order of the vertices (v,), where clusters begin (s + 1,)).

    The vertices of a material are halved, across the direction in which places and normals spread
    the most, until every part is small enough.
    """
    todo, done = [], []
    for m in np.unique(material)[::-1]:
        these = np.flatnonzero(material == m)
        size = max(1e-30, float(np.ptp(position[these], axis=0).max()))
        todo.append((these, np.hstack([position[these] / size, TURNED * normal[these]])))
    while todo:
        these, at = todo.pop()
        if len(these) <= CLUSTER:
            done.append(np.sort(these))
            continue
        spread = (at - at.mean(axis=0)).astype(np.float64)
        along = spread @ np.linalg.eigh(spread.T @ spread)[1][:, -1]
        half = np.argsort(along, kind="stable")
        for part in (half[len(half) // 2 :], half[: len(half) // 2]):
            todo.append((these[part], at[part]))
    return np.concatenate(done), np.cumsum([0, *map(len, done)]).astype(np.int32)


def _eyes(
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    corners: NDArray[np.int32],
    epsilon: float,
) -> NDArray[np.float32]:
    """(v, 3): off the surface, and at its rim on the triangle that goes in the most.

    A vertex at the edge of a wall lies in the plane of the next, half of which it would see from
    behind.
    """
    out = position + np.float32(LIFT * epsilon) * normal
    sides = np.sort(corners[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    edges, count = np.unique(sides, axis=0, return_counts=True)
    rim = np.zeros(len(position), np.bool_)
    rim[edges[count == 1]] = True
    inward, best = np.zeros((len(position), 3)), np.full(len(position), -np.inf)
    _move_in(position, corners, rim, LIFT * epsilon, inward, best, out)
    return out


@njit(cache=True, nogil=True)
def _move_in(position, corners, rim, lift, inward, best, out):
    for choose in (False, True):
        for t in range(corners.shape[0]):
            a, b, c = corners[t]
            p = vec(position, a)
            e1, e2 = sub(vec(position, b), p), sub(vec(position, c), p)
            up = normalize(cross(e1, e2))
            middle = add(p, scale(add(e1, e2), 1.0 / 3.0))
            for v in (a, b, c):
                if not rim[v]:
                    continue
                way = sub(middle, vec(position, v))
                if not choose:
                    for k in range(3):
                        inward[v, k] += way[k]
                elif dot(way, vec(inward, v)) > best[v]:
                    best[v] = dot(way, vec(inward, v))
                    for k in range(3):
                        out[v, k] = position[v, k] + INWARD * way[k] + lift * up[k]


@njit(cache=True, nogil=True)
def _frames(normal, given, out):
    """Fill out (v, 3) with the tangents that are given, or the frame's own where they are 0."""
    for i in range(out.shape[0]):
        n, t = vec(normal, i), vec(given, i)
        t = sub(t, scale(n, dot(n, t)))
        s = normalize(t) if dot(t, t) > 1e-12 else tangents(n)[0]
        for k in range(3):
            out[i, k] = s[k]


@njit(cache=True, nogil=True)
def _compare(corners, tangent, out):
    for t in range(out.shape[0]):
        a, b, c = corners[t]
        s = vec(tangent, a)
        out[t] = dot(s, vec(tangent, b)) > ALIKE and dot(s, vec(tangent, c)) > ALIKE


@njit
def frame(normal, tangent, i):
    """(s, t, n) of vertex i."""
    n, s = vec(normal, i), vec(tangent, i)
    return s, cross(n, s), n
