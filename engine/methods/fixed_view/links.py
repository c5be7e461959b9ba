"""Final-gather links: which gather clusters light a point, how strongly, and whether they see it.

`direct_to_indirect` §4.3 (Hašan et al. 2006), hierarchical as in N-body methods: a cluster that is
small as seen from the point gets one link, a larger one is opened. The irradiance that gather
sample j, with exitant radiance L_j, sends to point x is L_j times

    F_xj = V(x, j) cos θ_x cos θ_j A_j / (r² + A_j / π)

The term A_j / π makes the sample a disk in place of a point. So F_xj stays below π, and corners
need no clamp, where the paper clamps 1/r² and darkens them.

Two sizes steer the work, because a ray costs twenty times what the formula does. A *link* is a
cluster whose form factor is below `link_size`; it gets one shadow ray, to a random sample. Inside
a link the formula is evaluated for *patches*, clusters that are narrow (`patch_size`, diagonal by
distance), flat, and of samples that stand for about the same area.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.hierarchy import level_of, level_start
from engine.numerics.borrow import borrow
from engine.numerics.sampling import uniform
from engine.numerics.vec import add, dot, scale, sub, vec

FLAT = 0.9  # a patch's normals lie within 26 degrees of their mean
EVEN = 1.5  # areas of a patch's samples, the largest over the mean
DUST = 0.05  # part of `link_size` below which a patch need be none of narrow, flat and even
MAX_STACK = 128
MOST_CLOSURE = 4.0


class Links(NamedTuple):
    """Room for the links of a batch of points; a kernel argument as it is.

    origin     (r, 3) float32  start of the shadow ray of each link
    direction  (r, 3) float32  its direction; its length ends at the sample
    link       (p,) int32      the link that a patch belongs to
    cluster    (p,) int32      row of the patch's cluster in `Clusters`
    weight     (p,) float32    F_xj of each single sample j of the patch, V left out
    first      (b + 1,) int32  first patch of each point of the batch
    """

    origin: NDArray[np.float32]
    direction: NDArray[np.float32]
    link: NDArray[np.int32]
    cluster: NDArray[np.int32]
    weight: NDArray[np.float32]
    first: NDArray[np.int32]


def room_for_links(points: int, links: int, patches: int) -> Links:
    """Empty room for `points` points with so many links and patches together."""
    return Links(
        np.zeros((links, 3), np.float32),
        np.zeros((links, 3), np.float32),
        np.zeros(patches, np.int32),
        np.zeros(patches, np.int32),
        np.zeros(patches, np.float32),
        np.zeros(points + 1, np.int32),
    )


@njit(cache=True, nogil=True)
def find_links(
    index, position, normal, geometric, leaf_position, leaf_geometric, clusters, link_size,
    patch_size, epsilon, seed, out,
):  # fmt: skip
    """Fill `out` with the links of the points `index` (b,); -1 is no point.

    Returns the number of links, or -1 where the room does not suffice.
    """
    clusters, out = borrow(clusters), borrow(out)
    depth = clusters.depth
    links = patches = 0
    levels = np.zeros(MAX_STACK, np.int32)
    nodes = np.zeros(MAX_STACK, np.int64)
    below = (np.zeros(MAX_STACK, np.int32), np.zeros(MAX_STACK, np.int64))
    for b in range(index.shape[0]):
        out.first[b] = patches
        i = index[b]
        if i < 0:
            continue
        x, n, g = vec(position, i), vec(normal, i), vec(geometric, i)
        start = add(x, scale(g, epsilon))
        levels[0], nodes[0] = 0, 0
        top = 1
        while top > 0:
            top -= 1
            level, node = levels[top], nodes[top]
            factor = _upper_bound(clusters, level, node, x, n)
            if factor <= 0.0:
                continue
            if level < depth and factor > link_size:
                for k in range(4):
                    levels[top], nodes[top] = level + 1, 4 * node + (3 - k)
                    top += 1
                continue

            # Evaluate the formula over the link's patches, then aim its shadow ray.
            before = patches
            patches = _patches(
                clusters, level, node, x, n, patch_size, DUST * link_size, links, patches,
                borrow(below), out,
            )  # fmt: skip
            if patches < 0 or links >= out.origin.shape[0]:
                return -1
            if patches == before:
                continue
            count = 1 << (2 * (depth - level))
            j = node * count + int(uniform(seed, i, node * 16 + level) * count)
            sample = add(vec(leaf_position, j), scale(vec(leaf_geometric, j), epsilon))
            d = sub(sample, start)
            for k in range(3):
                out.origin[links, k] = start[k]
                out.direction[links, k] = d[k]
            links += 1
    out.first[index.shape[0]] = patches
    return links


@njit(cache=True, nogil=True)
def hide(first, link, weight, blocked):
    """Take the weight from the patches of links whose shadow ray is blocked (r,)."""
    for p in range(first[-1]):
        if blocked[link[p]]:
            weight[p] = 0.0


@njit(cache=True, nogil=True)
def closure(first, cluster, weight, depth, closed, sure):
    """Scale the rows of a batch in place so that each gathers from all that it sees, no more.

    A point's row sums to π times the closed part of its hemisphere, `closed` (b,). Where samples
    are sparser than the geometry, links to what is half hidden miss much of that. The sum is put
    right as far as it is off by more than `sure`, the standard error of `closed` at its largest.
    """
    for b in range(first.shape[0] - 1):
        total = 0.0
        for p in range(first[b], first[b + 1]):
            total += weight[p] * (1 << (2 * (depth - level_of(cluster[p]))))
        if total <= 0.0:
            continue
        total /= math.pi
        if closed[b] > total + sure:
            factor = min(MOST_CLOSURE, (closed[b] - sure * (closed[b] < 1.0)) / total)
        elif closed[b] < total - sure:
            factor = (closed[b] + sure) / total
        else:
            continue
        for p in range(first[b], first[b + 1]):
            weight[p] *= factor


@njit
def _upper_bound(clusters, level, node, x, n):
    """About the largest form factor that the cluster can have; 0 where it cannot be seen."""
    c = level_start(level) + node
    r = float(clusters.radius[c])
    v = sub(vec(clusters.centre, c), x)
    height = dot(v, n)
    if height + r <= 0.0:
        return 0.0
    d2 = dot(v, v)
    d = math.sqrt(d2)
    # The widest angle between a normal of the cluster and its way to x bounds the other cosine.
    facing = 1.0
    if d > r:
        toward = -dot(vec(clusters.axis, c), v) / d
        wide = math.acos(float(clusters.spread[c])) + math.asin(r / d)
        angle = math.acos(max(-1.0, min(1.0, toward))) - wide
        if angle >= 0.5 * math.pi:
            return 0.0
        facing = math.cos(max(0.0, angle))
    area = float(clusters.area[c]) * facing
    near = max(d - r, 0.25 * d)
    cosine = min(1.0, (height + r) / max(d, 1e-12))
    return area * cosine / max(near * near, 1e-20)


@njit
def _patches(clusters, level, node, x, n, patch_size, dust, link, patches, stack, out):
    """Append the patches of one link; returns the new count, -1 where the room does not suffice."""
    depth = clusters.depth
    levels, nodes = stack
    levels[0], nodes[0] = level, node
    top = 1
    while top > 0:
        top -= 1
        level, node = levels[top], nodes[top]
        c = level_start(level) + node
        v = sub(vec(clusters.centre, c), x)
        d2 = dot(v, v)
        d = math.sqrt(d2)
        size = 2.0 * clusters.radius[c]
        mixed = clusters.spread[c] < FLAT or clusters.uneven[c] > EVEN
        if level < depth and (size > patch_size * d or mixed):
            large = clusters.area[c] > dust * d2
            if large or size > d:
                for k in range(4):
                    levels[top], nodes[top] = level + 1, 4 * node + (3 - k)
                    top += 1
                continue
        cos_x = dot(v, n) / max(d, 1e-20)
        cos_j = -dot(v, vec(clusters.axis, c)) / max(d, 1e-20)
        if cos_x <= 0.0 or cos_j <= 0.0:
            continue
        if patches >= out.link.shape[0]:
            return -1
        out.link[patches] = link
        out.cluster[patches] = c
        area = float(clusters.area[c]) / (1 << (2 * (depth - level)))
        out.weight[patches] = cos_x * cos_j * area / (d2 + area / math.pi)
        patches += 1
    return patches
