"""Rows of a gather matrix, in wavelet space, culled and packed in tiles.

A *tile* is 64 points that lie together: 8 x 8 pixels, or three levels of the gather hierarchy. Its
rows share one list of wavelet ids, so the packed tile is a dense block of bytes. The paper gives
every row a list of its own (Hašan et al. 2006, §3.5); the shared list costs a third of the bytes
per coefficient and lets the product run at the speed of memory.

The list holds the wavelets with the greatest energy over the tile, weighted by their `importance`.
It is as long as it must be to keep what the rows would keep with the asked number of coefficients
each, a list of their own: typically twice that number.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.hierarchy import level_of, level_start
from engine.numerics.borrow import borrow

TILE = 64


class PackedRows(NamedTuple):
    """A matrix of `tiles` x 64 rows and n_g columns in wavelet space, 8 bits a coefficient.

    length   (tiles,) int32     wavelets in each tile's list; the lists follow each other
    ids      (q,) int32         wavelet
    scale    (q,) float32       value of one step of its coefficients
    steps    (q, 64) int8       its coefficients in the 64 rows, in units of scale
    """

    length: NDArray[np.int32]
    ids: NDArray[np.int32]
    scale: NDArray[np.float32]
    steps: NDArray[np.int8]


def no_rows(tiles: int) -> PackedRows:
    """So many tiles of zeros."""
    return PackedRows(
        np.zeros(tiles, np.int32),
        np.zeros(0, np.int32),
        np.zeros(0, np.float32),
        np.zeros((0, TILE), np.int8),
    )


class Scratch(NamedTuple):
    """Working memory of one thread, all zero (`slot`: all -1) between tiles.

    scaling  (c,) float32   scaling coefficient of every cluster
    touched  (c,) bool
    queue    (c,) int32     touched clusters, those of each level from the level's first row on
    energy   (n_g,) float64
    slot     (n_g,) int32   place of a wavelet in the tile's list
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


@njit(cache=True, nogil=True)
def pack(ids, values, starts, importance, coefficients, scratch, out_ids, out_scale, out_steps):
    """Choose one tile's wavelets and quantise its rows.

    ids, values, starts as from `project`; importance (n_g,) float32 weighs the coefficients of one
    wavelet against those of others; out_ids, out_scale (k,), out_steps (k, 64) get the tile's list,
    all zero before. Returns its length and the share of the weighted energy that it keeps.
    """
    scratch = borrow(scratch)

    # Sum the energy of every wavelet over the tile.
    found = 0
    mine = scratch.queue
    rows = starts.shape[0] - 1
    for q in range(starts[rows]):
        w = ids[q]
        if scratch.slot[w] == -1:
            scratch.slot[w] = -2
            mine[found] = w
            found += 1
        scratch.energy[w] += values[q] * values[q]

    # Ask how much each row would keep with a list of its own.
    target = 0.0
    for b in range(rows):
        n = starts[b + 1] - starts[b]
        own = np.zeros(n)
        for j in range(n):
            q = starts[b] + j
            own[j] = (values[q] * importance[ids[q]]) ** 2
        if n > coefficients:
            target += np.partition(own, n - coefficients)[n - coefficients :].sum()
        else:
            target += own.sum()

    # Keep those that matter most, until the tile has that much.
    energy = np.zeros(found)
    total = kept = 0.0
    for j in range(found):
        w = mine[j]
        energy[j] = -scratch.energy[w] * importance[w] * importance[w]
        total -= energy[j]
    order = np.argsort(energy, kind="mergesort")
    chosen = 0
    while chosen < min(found, out_ids.shape[0]) and kept < target:
        out_ids[chosen] = mine[order[chosen]]
        scratch.slot[out_ids[chosen]] = chosen
        kept -= energy[order[chosen]]
        chosen += 1

    # Scale each wavelet's coefficients to eight bits.
    for q in range(starts[rows]):
        k = scratch.slot[ids[q]]
        if k >= 0:
            out_scale[k] = max(out_scale[k], abs(values[q]) / 127.0)
    for b in range(rows):
        for q in range(starts[b], starts[b + 1]):
            k = scratch.slot[ids[q]]
            if k >= 0 and out_scale[k] > 0.0:
                out_steps[k, b] = int(np.rint(values[q] / out_scale[k]))
    for j in range(found):
        scratch.slot[mine[j]] = -1
        scratch.energy[mine[j]] = 0.0
    return chosen, (kept / total if total > 0.0 else 1.0)
