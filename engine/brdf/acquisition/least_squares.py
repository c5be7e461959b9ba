"""Moving least squares: scattered values made into a continuous function.

About a place x, the K nearest points x_k with values f_k are weighed by

    w_k = (1 - t)⁵ (5 t + 1),   t = |x_k - x| / R                         (Wendland 1995)

where R is a little more than the distance of the farthest of them. A linear function is fitted to
them, with a slight penalty r on its slopes that grows where all neighbours lie to one side. Its
value at x is a sum over the points, with c their centre and C their covariance about it:

    f(x) = Σ w_k (1 - aᵀ (x_k - x - c)) f_k,   (C + r) a = c,   Σ w_k = 1

It is then held within the values of the neighbours, where the farthest ones count ever less. Every
step is continuous in x, so that nothing shows steps; none can leave the range of the values.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from engine.numerics.parallel import for_ranges, thread_count

NEIGHBOURS = 24
BEYOND = 1.03  # R over the distance of the farthest neighbour
# R where every point is a neighbour: none can come or go, so the farthest one may count.
BEYOND_ALL = 2.0
RIDGE = 1e-4  # the penalty r, of squared distances over R
ONE_SIDED = 0.1  # how much of it is added times |c|⁴
FULL = 0.03  # a neighbour with this part of the largest weight may hold the value up alone
CROWD = 0.03  # points in a box of this size count as one, which stands at their mean
SPREAD = 1 / 3  # and so they do in one of this part of the spacing of n points in a unit box
BATCH = 1 << 17


@dataclass(frozen=True, eq=False)
class Cloud:
    """A function through points.

    tree    of their places (m, d)
    values  (m, 3) float64
    """

    tree: cKDTree
    values: NDArray[np.float64]

    def at(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Values (q, 3) at places (q, d)."""
        out = np.zeros((len(x), 3))
        k = min(NEIGHBOURS, len(self.values))
        beyond = BEYOND if k < len(self.values) else BEYOND_ALL
        # Neighbouring queries one after the other find the tree in the cache.
        order = np.lexsort(np.floor(16 * x).T)
        for start in range(0, len(x), BATCH):
            batch = order[start : start + BATCH]
            distance, nearest = self.tree.query(x[batch], k, workers=thread_count())
            fitted = np.zeros((len(batch), 3))
            for_ranges(
                _fit,
                len(batch),
                np.ascontiguousarray(x[batch]),
                np.asarray(self.tree.data),
                self.values,
                np.reshape(nearest, (-1, k)),
                np.reshape(distance, (-1, k)),
                beyond,
                fitted,
            )
            out[batch] = fitted
        return out


def cloud(places: NDArray[np.float64], values: NDArray[np.float64]) -> Cloud:
    """The function through values (n, 3) at places (n, d), n ≥ 1."""
    return Cloud(cKDTree(places, leafsize=32), np.ascontiguousarray(values))


def thinned(
    places: NDArray[np.float64], values: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Means of places (n, d) and values (n, 3) over the boxes of a grid, in a fixed order.

    Instruments crowd samples along circles. The neighbours of a place would then all come from one
    of them, and the function would step from circle to circle.
    """
    n, d = places.shape
    box = min(CROWD, SPREAD * n ** (-1 / d))
    _, index, count = np.unique(
        np.floor(places / box), axis=0, return_inverse=True, return_counts=True
    )
    both = np.concatenate([places, values], axis=1)
    means = np.zeros((len(count), d + 3))
    np.add.at(means, index.ravel(), both)
    means /= count[:, None]
    return means[:, :d], np.ascontiguousarray(means[:, d:])


@njit(cache=True, nogil=True)
def _fit(start, stop, queries, places, values, nearest, distance, beyond, out):
    """Fill out (q, 3) with fitted values at queries (q, d); nearest, distance (q, k)."""
    d, k = queries.shape[1], nearest.shape[1]
    weight, reach = np.zeros(k), np.zeros(k)
    offset = np.zeros((k, d))
    for i in range(start, stop):
        # Weigh the neighbours.
        radius = beyond * distance[i, k - 1] + 1e-12
        total = 0.0
        for j in range(k):
            t = distance[i, j] / radius
            weight[j] = (1.0 - t) ** 5 * (5.0 * t + 1.0)
            total += weight[j]
        for j in range(k):
            reach[j] = min(1.0, weight[j] / (FULL * weight[0]))
            weight[j] /= total
            for a in range(d):
                offset[j, a] = (places[nearest[i, j], a] - queries[i, a]) / radius

        # Find how the value at the query leans away from their centre.
        centre = np.zeros(d)
        for j in range(k):
            for a in range(d):
                centre[a] += weight[j] * offset[j, a]
        spread = np.zeros((d, d))
        for j in range(k):
            for a in range(d):
                for b in range(a + 1):
                    spread[a, b] += (
                        weight[j] * (offset[j, a] - centre[a]) * (offset[j, b] - centre[b])
                    )
        aside = 0.0
        for a in range(d):
            aside += centre[a] * centre[a]
        for a in range(d):
            spread[a, a] += RIDGE + ONE_SIDED * aside * aside
        lean = centre.copy()
        _solve(spread, lean)

        # Sum the values up and hold the sum within them.
        for c in range(3):
            mean = fitted = 0.0
            for j in range(k):
                share = 1.0
                for a in range(d):
                    share -= lean[a] * (offset[j, a] - centre[a])
                v = values[nearest[i, j], c]
                mean += weight[j] * v
                fitted += weight[j] * share * v
            low = high = mean
            for j in range(k):
                held = mean + reach[j] * (values[nearest[i, j], c] - mean)
                low, high = min(low, held), max(high, held)
            out[i, c] = min(max(fitted, low), high)


@njit
def _solve(m, x):
    """Replace x (d,) by the solution of m y = x; m (d, d) positive, its lower half overwritten."""
    d = x.shape[0]
    for a in range(d):
        for b in range(a + 1):
            s = m[a, b]
            for c in range(b):
                s -= m[a, c] * m[b, c]
            m[a, b] = math.sqrt(s) if a == b else s / m[b, b]
        for b in range(a):
            x[a] -= m[a, b] * x[b]
        x[a] /= m[a, a]
    for a in range(d - 1, -1, -1):
        for b in range(a + 1, d):
            x[a] -= m[b, a] * x[b]
        x[a] /= m[a, a]
