"""Rows of a gather matrix in wavelet space, and the form in which they are kept.

A *tile* is 64 points that lie together: 8 x 8 pixels, or three levels of the gather hierarchy. Its
rows share one list of wavelet ids. The paper gives every row a list of its own (Hašan et al. 2006,
§3.5). Neighbouring rows are much alike, so a wavelet's 64 coefficients are Haar-transformed once
more, over the points of the tile: `engine.methods.fixed_view.packing` keeps as many of those as
they are worth.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.hierarchy import level_of, level_start
from engine.numerics.borrow import borrow
from engine.numerics.packed import STEPS


class PackedRows(NamedTuple):
    """A matrix of `tiles` x 64 rows and n_g columns in wavelet space, 8 bits a coefficient.

    The rows of a tile are in quad-tree order. A wavelet's coefficients in them are its mean plus
    the `inverse` of scale · unit · steps, with `unit` the square root of the number of rows that a
    step covers. There are 64 steps, or the coarsest 16 or 4, or none. The first is always 0: in
    its place stands the mean.

    length   (tiles, 4) int32  wavelets in each tile's list that have 64, 16, 4, no steps; the lists
                               follow each other, within each those of 64 steps first
    ids      (q,) int32        wavelet
    mean     (q,) float32      of its coefficients over the tile
    scale    (s,) float32      value of one step of those wavelets that have any, in their order
    steps    (bytes,) int8     the steps of all wavelets, in their order
    """

    length: NDArray[np.int32]
    ids: NDArray[np.int32]
    mean: NDArray[np.float32]
    scale: NDArray[np.float32]
    steps: NDArray[np.int8]


def no_rows(tiles: int) -> PackedRows:
    """So many tiles of zeros."""
    nothing = np.zeros(0, np.float32)
    return PackedRows(
        np.zeros((tiles, len(STEPS)), np.int32),
        np.zeros(0, np.int32),
        nothing,
        nothing,
        np.zeros(0, np.int8),
    )


class Rows(NamedTuple):
    """Rows of a tile as `project` wants them.

    Row b sums the clusters first[b] to first[b + 1] of cluster (p,), each sample of them times
    weight (p,).
    """

    first: NDArray[np.int32]
    cluster: NDArray[np.int32]
    weight: NDArray[np.float32]


class Scratch(NamedTuple):
    """Working memory of one thread, all zero (`slot`: all -1) between tiles.

    scaling  (c,) float32   scaling coefficient of every cluster
    touched  (c,) bool
    queue    (c,) int32     touched clusters, those of each level from the level's first row on
    energy   (n_g,) float64
    slot     (n_g,) int32   place of a wavelet among those of the tile
    """

    scaling: NDArray[np.float32]
    touched: NDArray[np.bool_]
    queue: NDArray[np.int32]
    energy: NDArray[np.float64]
    slot: NDArray[np.int32]


def make_scratch(samples: int) -> Scratch:
    """For a cloud of so many samples."""
    clusters = (4 * samples - 1) // 3
    return Scratch(
        np.zeros(clusters, np.float32),
        np.zeros(clusters, np.bool_),
        np.zeros(clusters, np.int32),
        np.zeros(samples, np.float64),
        np.full(samples, -1, np.int32),
    )


@njit(cache=True, nogil=True)
def project(first, cluster, weight, depth, scratch, ids, values, starts):
    """Haar coefficients of the rows of one batch.

    Row b sums the clusters first[b] to first[b + 1]; weight (p,) is what each sample of the cluster
    adds. Fills ids, values (q,) and starts (b + 1,): row b owns starts[b] to starts[b + 1]. Returns
    the number of coefficients, or -1 where the room does not suffice.
    """
    scratch = borrow(scratch)
    tail = np.zeros(depth + 1, np.int64)
    count = 0
    for b in range(first.shape[0] - 1):
        starts[b] = count
        # Mark the clusters that are above a visible patch, level by level.
        tail[:] = 0
        for p in range(first[b], first[b + 1]):
            if weight[p] == 0.0:
                continue
            c = cluster[p]
            level = level_of(c)
            scratch.scaling[c] += weight[p] * (1 << (depth - level))
            while not scratch.touched[c]:
                scratch.touched[c] = True
                scratch.queue[level_start(level) + tail[level]] = c
                tail[level] += 1
                if level > 0:
                    c = (c - 1) // 4
                    level -= 1
        if tail[0] == 0:
            continue

        # Transform from the leaves up. A parent yields at most three coefficients.
        if count + 3 * tail.sum() + 1 > ids.shape[0]:
            _clear(scratch, tail)
            return -1
        for level in range(depth - 1, -1, -1):
            start = level_start(level)
            for k in range(start, start + tail[level]):
                c = scratch.queue[k]
                child = 4 * c + 1
                v0, v1 = scratch.scaling[child], scratch.scaling[child + 1]
                v2, v3 = scratch.scaling[child + 2], scratch.scaling[child + 3]
                if v0 == 0.0 and v1 == 0.0 and v2 == 0.0 and v3 == 0.0:
                    continue
                base = (1 << (2 * level)) + 3 * (c - start)
                for j in range(3):
                    ids[count + j] = base + j
                values[count] = 0.5 * (v0 - v1 + v2 - v3)
                values[count + 1] = 0.5 * (v0 + v1 - v2 - v3)
                values[count + 2] = 0.5 * (v0 - v1 - v2 + v3)
                count += 3
                scratch.scaling[c] += 0.5 * (v0 + v1 + v2 + v3)
        ids[count], values[count] = 0, scratch.scaling[0]
        count += 1
        _clear(scratch, tail)
    starts[first.shape[0] - 1] = count
    return count


@njit
def _clear(scratch, tail):
    for level in range(tail.shape[0]):
        start = level_start(level)
        for k in range(start, start + tail[level]):
            scratch.scaling[scratch.queue[k]] = 0.0
            scratch.touched[scratch.queue[k]] = False
