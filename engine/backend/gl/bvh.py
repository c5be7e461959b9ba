"""A tree of boxes over triangles, for the rays of `shaders/common/bvh.glsl`.

Every node of two holds the boxes of both its children. It is split where the surface area
heuristic, over BINS bins along each axis, is least (Wald 2007, *On fast Construction of SAH-based
Bounding Volume Hierarchies*). Below DEEP levels, and where all lie in one place, it is cut in
halves as they come, so that its depth stays under the shader's stack whatever the triangles.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

LEAF = 4  # triangles at most, 7 in the shader's encoding
BINS = 16
DEEP = 32
MOST_TRIANGLES = 1 << 27  # of which a leaf can hold the place


class Tree(NamedTuple):
    """A tree as the shader reads it.

    nodes    (m, 4, 4) float32  low corner of either child's box, then high corner of either; in the
                                last column of the first two rows, as int32 bits, the children: a
                                node, or -1 - (8 first + count) for so many triangles
    corners  (t, 3, 4) float32  the triangles in the order of the leaves; in the last column of the
                                first corner, as int32 bits, which triangle it is
    """

    nodes: NDArray[np.float32]
    corners: NDArray[np.float32]


def build_tree(positions: NDArray[np.float32], triangles: NDArray[np.int32]) -> Tree:
    """Of positions (v, 3) and triangles (t, 3); three seconds per million."""
    if len(triangles) > MOST_TRIANGLES:
        raise ValueError(f"{len(triangles)} triangles are more than {MOST_TRIANGLES}")
    corners = positions[triangles]
    low, high = corners.min(axis=1), corners.max(axis=1)
    order = np.arange(len(triangles), dtype=np.int32)
    nodes = np.zeros((max(1, len(triangles)), 4, 4), np.float32)
    count = _build(low, high, order, nodes, nodes.view(np.int32))
    sorted_corners = np.zeros((len(triangles), 3, 4), np.float32)
    sorted_corners[:, :, :3] = corners[order]
    sorted_corners.view(np.int32)[:, 0, 3] = order
    return Tree(nodes[:count].copy(), sorted_corners)


@njit(cache=True, nogil=True)
def _build(low, high, order, nodes, links):
    """Fill nodes and sort order; returns the number of nodes."""
    nodes[0, 0:2, :3] = np.inf  # a child that is not there is met by no ray
    nodes[0, 2:4, :3] = -np.inf
    links[0, 0:2, 3] = -1
    scratch = np.zeros_like(order)
    count = 1
    # What is to be done: (first, last, depth, node and child to hang it on).
    stack = [(0, order.shape[0], 0, 0, 0)]
    while len(stack) > 0:
        first, last, depth, node, child = stack.pop()
        for axis in range(3):
            lowest, highest = np.float32(np.inf), np.float32(-np.inf)
            for k in range(first, last):
                lowest = min(lowest, low[order[k], axis])
                highest = max(highest, high[order[k], axis])
            nodes[node, child, axis], nodes[node, 2 + child, axis] = lowest, highest
        if last - first <= LEAF:
            links[node, child, 3] = -1 - (8 * first + last - first)
            continue
        middle = _split(low, high, order, scratch, first, last, depth)
        # The root is the first child that would hang on itself.
        mine = 0
        if depth > 0:
            mine = count
            count += 1
            links[node, child, 3] = mine
        stack.append((first, middle, depth + 1, mine, 0))
        stack.append((middle, last, depth + 1, mine, 1))
    return count


@njit
def _split(low, high, order, scratch, first, last, depth):
    """Sort order[first:last] into two parts and return where the second begins."""
    best_cost, best_axis, best_bin = np.inf, -1, 0
    if depth < DEEP:
        for axis in range(3):
            least, most = _spread(low, high, order, first, last, axis)
            if least < most:
                cost, where = _best_bin(low, high, order, first, last, axis, least, most)
                if cost < best_cost:
                    best_cost, best_axis, best_bin = cost, axis, where
    if best_axis < 0:
        return (first + last) // 2
    least, most = _spread(low, high, order, first, last, best_axis)
    left, right = first, 0
    for k in range(first, last):
        i = order[k]
        if _bin(np.float64(low[i, best_axis]) + high[i, best_axis], least, most) < best_bin:
            order[left] = i
            left += 1
        else:
            scratch[right] = i
            right += 1
    for k in range(right):
        order[left + k] = scratch[k]
    return left


@njit
def _spread(low, high, order, first, last, axis):
    """Bounds of the boxes' centres, twice over: of low + high."""
    least, most = np.inf, -np.inf
    for k in range(first, last):
        c = np.float64(low[order[k], axis]) + high[order[k], axis]
        least, most = min(least, c), max(most, c)
    return least, most


@njit
def _bin(c, least, most):
    return min(BINS - 1, int(BINS * ((c - least) / (most - least))))


@njit
def _best_bin(low, high, order, first, last, axis, least, most):
    """(cost, bin that the right part begins with): the areas by the numbers of both parts."""
    number = np.zeros(BINS, np.int64)
    box = np.zeros((BINS, 6))
    box[:, :3], box[:, 3:] = np.inf, -np.inf
    for k in range(first, last):
        i = order[k]
        b = _bin(np.float64(low[i, axis]) + high[i, axis], least, most)
        number[b] += 1
        for a in range(3):
            box[b, a] = min(box[b, a], low[i, a])
            box[b, 3 + a] = max(box[b, 3 + a], high[i, a])
    right_cost = np.zeros(BINS)
    right = box[BINS - 1].copy()
    held = number[BINS - 1]
    for b in range(BINS - 1, 0, -1):
        if b < BINS - 1:
            _grow(right, box[b])
            held += number[b]
        right_cost[b] = held * _area(right) if held > 0 else np.inf
    best, where = np.inf, 1
    left, held = box[0].copy(), number[0]
    for b in range(1, BINS):
        if b > 1:
            _grow(left, box[b - 1])
            held += number[b - 1]
        if held > 0 and held * _area(left) + right_cost[b] < best:
            best, where = held * _area(left) + right_cost[b], b
    return best, where


@njit
def _grow(box, other):
    for a in range(3):
        box[a] = min(box[a], other[a])
        box[3 + a] = max(box[3 + a], other[3 + a])


@njit
def _area(box):
    x, y, z = box[3] - box[0], box[4] - box[1], box[5] - box[2]
    return x * y + y * z + z * x
