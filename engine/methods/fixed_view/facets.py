"""Facets: the parts of triangles that the gather cloud is drawn from, and the drawing.

`direct_to_indirect` §4.1 (Hašan et al. 2006): facets are split by axis-aligned planes into halves
of equal weight, the budget of samples with them, until one facet is left, which is sampled evenly,
or a budget of one, for which a facet is drawn by weight.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.sides import triangle_areas
from engine.numerics.boxes import widest
from engine.numerics.sampling import uniform
from engine.scene.scene import Scene

MOST_CUTS = 256  # of an edge


class Facets(NamedTuple):
    """Parts of the sides of triangles: n triangles with corners on those of the scene.

    triangle  (n,) int32
    back      (n,) bool             whether it is the back of it
    corner    (n, 3, 2) float32     barycentric coordinates b1, b2
    area      (n,) float64          m²
    cuts      (t,) int64            parts of each edge of the scene's triangles
    first     (t, 2) int64          first facet of each side, -1 for none
    """

    triangle: NDArray[np.int32]
    back: NDArray[np.bool_]
    corner: NDArray[np.float32]
    area: NDArray[np.float64]
    cuts: NDArray[np.int64]
    first: NDArray[np.int64]


def facets(scene: Scene, sides: NDArray[np.bool_], largest: float = np.inf) -> Facets:
    """The sides (t, 2) that are True, cut into equal parts no larger than `largest` m²."""
    area = triangle_areas(scene)
    cuts = np.clip(np.ceil(np.sqrt(area / largest)), 1, MOST_CUTS).astype(np.int64)
    item = np.flatnonzero(sides.ravel())
    parts = cuts[item // 2] ** 2
    start = np.cumsum(parts) - parts
    first = np.full(sides.size, -1, np.int64)
    first[item] = start
    triangle = np.repeat(item // 2, parts)
    corner = np.zeros((len(triangle), 3, 2), np.float32)
    _cut(cuts[triangle], np.arange(len(triangle)) - np.repeat(start, parts), corner)
    return Facets(
        triangle.astype(np.int32),
        np.repeat((item & 1).astype(np.bool_), parts),
        corner,
        area[triangle] / cuts[triangle] ** 2,
        cuts,
        first.reshape(sides.shape),
    )


def facet_centres(scene: Scene, of: Facets) -> NDArray[np.float64]:
    """(n, 3) float64, m."""
    corners = scene.geometry.positions[scene.geometry.triangles[of.triangle]].astype(np.float64)
    b = of.corner.mean(axis=1, dtype=np.float64)
    share = np.stack([1 - b[:, 0] - b[:, 1], b[:, 0], b[:, 1]], axis=1)
    centres: NDArray[np.float64] = np.einsum("nk,nkc->nc", share, corners)
    return centres


def draw(
    centre: NDArray[np.float64], weight: NDArray[np.float64], count: int, seed: int
) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """(facet (count,), place on it (count, 2)): about as many of each facet as its weight says.

    centre (n, 3), weight (n,). A place is a pair of barycentric coordinates of the facet.
    """
    picked = np.zeros(count, np.int32)
    place = np.zeros((count, 2), np.float32)
    _split_and_sample(np.arange(len(weight), dtype=np.int32), centre, weight, seed, picked, place)
    return picked, place


def on_triangles(
    of: Facets, picked: NDArray[np.int32], place: NDArray[np.float32]
) -> NDArray[np.float32]:
    """(n, 2) float32: barycentric coordinates in triangles, from places (n, 2) on facets (n,)."""
    corner = of.corner[picked]
    edges = corner[:, 1:] - corner[:, :1]
    return corner[:, 0] + place[:, :1] * edges[:, 0] + place[:, 1:] * edges[:, 1]


def facet_at(
    of: Facets,
    triangle: NDArray[np.int32],
    back: NDArray[np.bool_],
    barycentric: NDArray[np.float32],
) -> NDArray[np.int64]:
    """(n,) the facet at barycentric coordinates (n, 2) on sides of triangles (n,), -1 for none."""
    cuts, first = of.cuts[triangle], of.first[triangle, back.astype(np.intp)]
    x, y = (barycentric * cuts[:, None]).T
    # Rounding may put a place on a far edge into a row or column that is not there.
    i = np.minimum(x.astype(np.int64), cuts - 1)
    j = np.minimum(y.astype(np.int64), cuts - 1 - i)
    upper = (x - i + y - j > 1) & (i + j < cuts - 1)
    return np.where(first < 0, -1, first + i * (2 * cuts - i) + 2 * j + upper)


@njit(cache=True)
def _cut(cuts, part, corner):
    """Corners (n, 3, 2) of part number `part` (n,) of triangles cut `cuts` (n,) times."""
    for k in range(part.shape[0]):
        # Row i holds the parts with b1 from i / cuts on: 2 (cuts - i) - 1 of them.
        i, rest = 0, part[k]
        while rest >= 2 * (cuts[k] - i) - 1:
            rest -= 2 * (cuts[k] - i) - 1
            i += 1
        j, upper = rest // 2, rest % 2
        places = ((i, j), (i + 1, j), (i, j + 1))
        if upper == 1:
            places = ((i + 1, j + 1), (i, j + 1), (i + 1, j))
        for c in range(3):
            corner[k, c, 0] = places[c][0] / cuts[k]
            corner[k, c, 1] = places[c][1] / cuts[k]


@njit(cache=True, nogil=True)
def _split_and_sample(items, centre, weight, seed, picked, place):
    """Fill picked (count,) with items and place (count, 2) with places on them."""
    stack = [(0, items.shape[0], 0, picked.shape[0])]
    while len(stack) > 0:
        first, last, out, budget = stack.pop()
        run = items[first:last]
        if budget == 1 or last - first == 1:
            _sample_run(run, weight, out, budget, seed, picked, place)
            continue

        # Sort along the longest axis of the box around the centres.
        axis = widest(centre, run)
        key = np.zeros(len(run))
        for j in range(len(run)):
            key[j] = centre[run[j], axis]
        run[:] = run[np.argsort(key, kind="mergesort")]

        # Cut where half of the weight lies on each side, and round the budget's halves at random.
        total = 0.0
        for i in run:
            total += weight[i]
        cut, left = 0, 0.0
        while cut < len(run) - 1 and (cut == 0 or left + 0.5 * weight[run[cut]] < 0.5 * total):
            left += weight[run[cut]]
            cut += 1
        share = budget * left / total if total > 0.0 else 0.0
        part = int(share)
        if uniform(seed, out, budget) < share - part:
            part += 1
        if part > 0:
            stack.append((first, first + cut, out, part))
        if budget - part > 0:
            stack.append((first + cut, last, out + part, budget - part))


@njit
def _sample_run(run, weight, out, budget, seed, picked, place):
    # One sample among several facets: draw the facet by weight.
    item = run[0]
    if len(run) > 1:
        total = 0.0
        for i in run:
            total += weight[i]
        threshold = uniform(seed, out, 1000000) * total
        for i in run:
            threshold -= weight[i]
            if threshold <= 0.0:
                item = i
                break

    # Several samples on one facet: the plastic-number sequence spreads them evenly (Roberts 2018).
    shift1, shift2 = uniform(seed, out, 1000001), uniform(seed, out, 1000002)
    for k in range(budget):
        u1 = (shift1 + k * 0.7548776662466927) % 1.0
        u2 = (shift2 + k * 0.5698402909980532) % 1.0
        # Folding the square keeps the even spread, which a square root would stretch.
        if u1 + u2 > 1.0:
            u1, u2 = 1.0 - u1, 1.0 - u2
        picked[out + k] = item
        place[out + k, 0] = u1
        place[out + k, 1] = u2
