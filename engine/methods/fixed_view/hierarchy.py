"""The balanced quad-tree over the gather samples: `direct_to_indirect` §3.4 and §4.2.

Every cluster has four children of equal size. A set of samples is split into equal halves by a
two-means that sorts: the samples are ordered by d(s, c1) - d(s, c2) and cut in the middle, the
centroids are taken anew, until nothing moves. Two such splits make four children. The order of the
leaves is the order of the gather samples, and the Haar basis of `engine.numerics.haar` is on it.

    d(s, c) = K² |p_s - p_c|² + D² |n_s - n_c|²        (eq. 9), D the scene's diagonal
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.boxes import widest
from engine.numerics.haar import levels
from engine.numerics.parallel import for_ranges

ITERATIONS = 20


class Clusters(NamedTuple):
    """All clusters, root first, level by level; a kernel argument as it is.

    Cluster j of level l is row (4^l - 1) / 3 + j and covers the samples j·4^(L-l) onwards, L the
    number of levels below the root.

    depth     int                  L
    centre    (c, 3) float32       mean position
    radius    (c,) float32         half of the bounding box's diagonal
    axis      (c, 3) float32       unit mean normal (the first sample's where they cancel)
    spread    (c,) float32         cosine of the widest angle between axis and a sample's normal
    area      (c,) float32         m² of all its samples
    uneven    (c,) float32         the largest area of a sample over the mean one
    """

    depth: int
    centre: NDArray[np.float32]
    radius: NDArray[np.float32]
    axis: NDArray[np.float32]
    spread: NDArray[np.float32]
    area: NDArray[np.float32]
    uneven: NDArray[np.float32]


def build_order(
    position: NDArray[np.float32], normal: NDArray[np.float32], diagonal: float, K: float
) -> NDArray[np.int64]:
    """Order (n,) that sorts the samples into the tree.

    position, normal (n, 3) float32, n a power of four; K the weight on positions (20 to 40).
    """
    n = len(position)
    # With these features eq. 9 is a plain squared distance.
    features = np.concatenate([K * position, diagonal * normal], axis=1).astype(np.float32)
    order = np.arange(n)
    size = n
    while size > 1:
        for_ranges(_split_runs, n // size, features, order, size, grain=1)
        size //= 2
    return order


@njit(cache=True, nogil=True)
def _split_runs(start, stop, features, order, size):
    """Split each run of `size` samples of `order` into equal halves, the nearer ones first."""
    half = size // 2
    c1, c2 = np.zeros(6), np.zeros(6)
    key = np.zeros(size, np.float32)
    for run in range(start, stop):
        members = order[run * size : (run + 1) * size]
        # Start from halves along the feature that varies most.
        feature = widest(features, members)
        for i in range(size):
            key[i] = features[members[i], feature]
        members[:] = members[np.argsort(key, kind="mergesort")]
        for _ in range(ITERATIONS):
            c1[:], c2[:] = 0.0, 0.0
            for i in range(half):
                for f in range(6):
                    c1[f] += features[members[i], f]
                    c2[f] += features[members[half + i], f]
            for i in range(size):
                difference = 0.0
                for f in range(6):
                    x = features[members[i], f]
                    difference += (x - c1[f] / half) ** 2 - (x - c2[f] / half) ** 2
                key[i] = difference
            if key[:half].max() <= key[half:].min():
                break
            members[:] = members[np.argsort(key, kind="mergesort")]


def describe_clusters(
    position: NDArray[np.float32], normal: NDArray[np.float32], area: NDArray[np.float32]
) -> Clusters:
    """The clusters over samples that are in tree order; area (n,), m²."""
    depth = levels(len(position))
    centre, radius, axis, spread, sizes, uneven = [], [], [], [], [], []
    for level in range(depth + 1):
        p = position.reshape(4**level, -1, 3)
        n = normal.reshape(4**level, -1, 3)
        a = area.astype(np.float64).reshape(4**level, -1)
        extent = p.max(axis=1) - p.min(axis=1)
        mean = n.mean(axis=1)
        length = np.linalg.norm(mean, axis=1, keepdims=True)
        unit = np.where(length > 1e-3, mean / np.maximum(length, 1e-3), n[:, 0])
        centre.append(p.mean(axis=1))
        radius.append(0.5 * np.linalg.norm(extent, axis=1))
        axis.append(unit)
        spread.append(np.einsum("cij,cj->ci", n, unit).min(axis=1))
        sizes.append(a.sum(axis=1))
        uneven.append(a.max(axis=1) / a.mean(axis=1))
    return Clusters(
        depth,
        np.concatenate(centre).astype(np.float32),
        np.concatenate(radius).astype(np.float32),
        np.concatenate(axis).astype(np.float32),
        np.clip(np.concatenate(spread), -1, 1).astype(np.float32),
        np.concatenate(sizes).astype(np.float32),
        np.concatenate(uneven).astype(np.float32),
    )


@njit
def level_start(level):
    """Row of the first cluster of a level."""
    return ((1 << (2 * level)) - 1) // 3


@njit
def level_of(c):
    """Level of cluster row c: the l with (4^l - 1) / 3 ≤ c < (4^(l+1) - 1) / 3."""
    level = 0
    while (1 << (2 * (level + 1))) - 1 <= 3 * c:
        level += 1
    return level
