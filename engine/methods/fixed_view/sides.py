"""Which sides of which triangles light can travel from to the picture.

Surfaces are two-sided, but the inside of a closed box needs no gather samples. Particles leave the
view samples and bounce about like light; the sides they touch are *exposed*. A triangle that no
particle found takes the verdict of the smooth piece of mesh that it belongs to. The same particles
are the importance of §4.1 (Hašan et al. 2006) at its coarsest: yes or no.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from engine.methods.fixed_view.frame_buffer import Points
from engine.numerics.frames import tangents, to_world
from engine.numerics.parallel import for_ranges
from engine.numerics.sampling import cosine_hemisphere, uniform
from engine.numerics.vec import add, dot, scale, vec
from engine.scene import surface
from engine.scene.rays import Hits
from engine.scene.scene import Scene

PARTICLES = 262144
BOUNCES = 6
# A side is exposed where particles are at least this dense, against their mean over what they hit.
DENSE = 0.02
# Below so many expected hits, a triangle's own count says too little and its piece of mesh decides.
ENOUGH = 20
# Rays that ask whether a sample of an exposed side looks out on exposed sides itself, and how many
# of them must find one that is not nearer than CLOSE, in sizes of the scene. In cracks and behind
# mouldings there is hardly any light, and a cluster that mixes it with what is lit in front passes
# on too little. In the corner of three walls a quarter of them do.
LOOKS, OUTLOOKS = 16, 4
CLOSE = 0.02


def exposed_sides(scene: Scene, points: Points, seed: int) -> NDArray[np.bool_]:
    """(t, 2) bool: front and back of every triangle."""
    hits = np.zeros((len(scene.geometry.triangles), 2), np.int64)
    met = points.take(np.flatnonzero(points.model >= 0))
    if len(met) == 0:
        return np.tile([True, False], (len(hits), 1))
    chosen = evenly_chosen(met, PARTICLES)
    position, normal = chosen.position, chosen.geometric

    # What the camera sees is exposed, however few particles come back to it.
    above = met.position + 4 * scene.rays.epsilon * met.geometric
    seen = scene.rays.intersect(above, -met.geometric, 8 * scene.rays.epsilon)
    sides = np.zeros_like(hits, np.bool_)
    side = sides_met(scene, seen, -met.geometric)[0]
    sides[seen.triangle[seen.triangle >= 0], side[seen.triangle >= 0]] = True

    # Bounce: every hit is counted for its side and becomes the start of the next flight.
    for bounce in range(BOUNCES):
        n = len(position)
        origin = np.zeros((n, 3), np.float32)
        direction = np.zeros((n, 3), np.float32)
        args = (position, normal, scene.rays.epsilon, seed + bounce, origin, direction)
        for_ranges(cosine_rays, n, *args)
        found = scene.rays.intersect(origin, direction)
        side, position, normal = sides_met(scene, found, direction)
        alive = found.triangle >= 0
        np.add.at(hits, (found.triangle[alive], side[alive]), 1)
        position, normal = position[alive], normal[alive]

    # Compare with the hits that a side of its area gets on average.
    area = triangle_areas(scene)
    mean = hits.sum() / max(float((area[:, None] * (hits > 0)).sum()), 1e-30)
    piece = smooth_pieces(scene)
    of_piece = np.zeros((piece.max() + 1, 2), np.int64)
    np.add.at(of_piece, piece, hits)
    expected, expected_of_piece = mean * area, mean * np.bincount(piece, area)
    verdict = of_piece > DENSE * expected_of_piece[:, None]
    verdict[of_piece.sum(axis=1) == 0] = (True, False)
    dense = hits > DENSE * expected[:, None]
    return sides | np.where((expected > ENOUGH)[:, None], dense, (hits > 0) | verdict[piece])


def looks_out(
    scene: Scene,
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    sides: NDArray[np.bool_],
    seed: int,
) -> NDArray[np.bool_]:
    """(n,) bool: whether points see exposed sides some way off or the sky, by LOOKS rays each.

    What lies between a wall and its back, or beyond the room, belongs to a triangle that is exposed
    elsewhere and still passes no light to the picture.
    """
    n = len(position)
    found = np.zeros(n, np.uint8)
    origin, direction = np.zeros((n, 3), np.float32), np.zeros((n, 3), np.float32)
    for look in range(LOOKS):
        args = (position, normal, scene.rays.epsilon, seed + look, origin, direction)
        for_ranges(cosine_rays, n, *args)
        hits = scene.rays.intersect(origin, direction)
        side, _, _ = sides_met(scene, hits, direction)
        far = hits.distance > CLOSE * scene.diagonal
        found += (hits.triangle < 0) | (sides[hits.triangle, side] & far)
    return found >= OUTLOOKS


def evenly_chosen(points: Points, count: int) -> Points:
    """`count` of the points that lie on something, some of them often; none if none does."""
    start = np.flatnonzero(points.model >= 0)
    if len(start) == 0:
        return points.take(start)
    return points.take(start[np.linspace(0, len(start) - 1, count).astype(np.intp)])


def sides_met(
    scene: Scene, hits: Hits, direction: NDArray[np.float32]
) -> tuple[NDArray[np.int8], NDArray[np.float32], NDArray[np.float32]]:
    """(side (n,) int8, position (n, 3), normal (n, 3)) of hits, on the side that was met."""
    n = len(direction)
    side = np.zeros(n, np.int8)
    position, normal = np.zeros((n, 3), np.float32), np.zeros((n, 3), np.float32)
    for_ranges(
        _arrive, n, scene.geometry, hits.triangle, hits.b1, hits.b2, direction, position, normal,
        side,
    )  # fmt: skip
    return side, position, normal


def triangle_areas(scene: Scene) -> NDArray[np.float64]:
    """(t,) float64, m²."""
    corners = scene.geometry.positions[scene.geometry.triangles].astype(np.float64)
    edges = corners[:, 1:] - corners[:, :1]
    return 0.5 * np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)


def triangle_normals(scene: Scene) -> NDArray[np.float64]:
    """(t, 3) float64, unit, on the counter-clockwise side; 0 for triangles without an area."""
    corners = scene.geometry.positions[scene.geometry.triangles].astype(np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normal / np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)


def smooth_pieces(scene: Scene) -> NDArray[np.int32]:
    """(t,) int32: triangles that share a vertex belong to one piece."""
    triangles = scene.geometry.triangles
    n = len(scene.geometry.positions)
    a = np.concatenate([triangles[:, 0], triangles[:, 1]])
    b = np.concatenate([triangles[:, 1], triangles[:, 2]])
    graph = coo_array((np.ones(len(a), np.int8), (a, b)), shape=(n, n))
    _, label = connected_components(graph, directed=False)
    return label[triangles[:, 0]]


@njit(cache=True, nogil=True)
def cosine_rays(start, stop, position, normal, epsilon, seed, origin, direction):
    """Fill origin, direction (n, 3) with a ray from each place, by the cosine to its normal."""
    for i in range(start, stop):
        n = vec(normal, i)
        s, t = tangents(n)
        w = to_world(cosine_hemisphere(uniform(seed, i, 0), uniform(seed, i, 1)), s, t, n)
        o = add(vec(position, i), scale(n, epsilon))
        for k in range(3):
            origin[i, k] = o[k]
            direction[i, k] = w[k]


@njit(cache=True, nogil=True)
def _arrive(start, stop, geometry, triangle, b1, b2, direction, position, normal, side):
    for i in range(start, stop):
        t = triangle[i]
        if t < 0:
            continue
        p = surface.position(geometry, t, b1[i], b2[i])
        g = surface.geometric_normal(geometry, t)
        if dot(g, vec(direction, i)) > 0.0:
            side[i] = 1
            g = scale(g, -1.0)
        for k in range(3):
            position[i, k] = p[k]
            normal[i, k] = g[k]
