"""Values of an encoded BRDF, straight from its block (Claustres et al. 2007, §5.3, §5.4).

A value is put together from the root down: at each split its half of what the cell reflects, by
the odds that the node's coefficient says. Coefficients are bilinear between incident directions;
values are bilinear between the cells of outgoing directions around wo. The four cells share most of
their way down, so what was found on the way to one serves the next. A coarser level stops earlier.

`a` is the address of a block, see `layout`; kernels read it word by word.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from engine.brdf.wavelet.lane_step import go_down, start
from engine.brdf.wavelet.layout import (
    ACROSS,
    CHANNELS,
    DOWN,
    FIRST_ROW,
    FIRST_TILE,
    FLOOR,
    GENERAL,
    ISOTROPIC,
    MAP,
    ORTHOTROPIC,
    PHI_BITS,
    PHI_RATIOS,
    PHI_SHARES,
    RANGES,
    ROOT,
    SCHEDULE,
    SYMMETRY,
    THETA_BITS,
    THETA_RATIOS,
    THETA_SHARES,
    TILE,
)
from engine.numerics.dispatch import contracted
from engine.numerics.lanes import COUNT
from engine.numerics.memory import (
    float32_at,
    int32_at,
    load_float,
    load_int,
    stack_words,
    store_float,
    store_int,
    uint8_at,
    uint16_at,
)
from engine.numerics.tangent_poles import coordinates

MOST_DEPTH = 16
NODES = MOST_DEPTH + 1
SCRATCH = COUNT * NODES
ZERO, ONE = np.float32(0.0), np.float32(1.0)


@contracted
def levels(a):
    """N: how often both angles can be halved."""
    return min(int32_at(a, THETA_BITS), int32_at(a, PHI_BITS))


@contracted
def turned(a, plane, tree):
    """The pair as the block knows it: (direction on the plane, direction in the tree).

    Isotropic: about the normal so that the first lies over x, y of the second not negative.
    Orthotropic: both mirrored so that the second lies in the quarter with x, y > 0.
    """
    symmetry = int32_at(a, SYMMETRY)
    if symmetry == ISOTROPIC:
        r = math.sqrt(plane[0] * plane[0] + plane[1] * plane[1])
        c, s = (plane[0] / r, plane[1] / r) if r > 1e-12 else (1.0, 0.0)
        x, y = c * tree[0] + s * tree[1], c * tree[1] - s * tree[0]
        return (r, 0.0, plane[2]), (x, abs(y), tree[2])
    if symmetry == ORTHOTROPIC:
        sx, sy = math.copysign(1.0, tree[0]), math.copysign(1.0, tree[1])
        return (sx * plane[0], sy * plane[1], plane[2]), (abs(tree[0]), abs(tree[1]), tree[2])
    return plane, tree


@contracted
def plane_taps(a, w):
    """(column, row, fx, fy) of the first of the four incident directions around w."""
    across, down = int32_at(a, ACROSS), int32_at(a, DOWN)
    u, v = coordinates(w)
    if int32_at(a, SYMMETRY) == ISOTROPIC:
        x, y = (1.0 - 2.0 * u) * (across - 0.5), 0.0
    else:
        x, y = u * across - 0.5, v * down - 0.5
    x, y = min(max(x, 0.0), across - 1.0), min(max(y, 0.0), down - 1.0)
    i, j = min(int(x), max(0, across - 2)), min(int(y), max(0, down - 2))
    return i, j, np.float32(x - i), np.float32(y - j)


@contracted
def root_at(a, taps, reflected):
    """Write the mean values over the whole tree for an incident direction, floor included."""
    i, j, fx, fy = taps
    across = int32_at(a, ACROSS)
    p = np.int64(int32_at(a, ROOT)) + 3 * (j * across + i)
    below = np.int64(12 * across if int32_at(a, DOWN) > 1 else 0)
    start(reflected, a + np.uint64(4 * p), below, fx, fy)


@contracted
def tile_places(a, taps):
    """(tile's number in its slice, tiles in a slice, octets in a tile, place of the first tap)."""
    i, j, _, _ = taps
    wide = (int32_at(a, ACROSS) + TILE - 1) // TILE
    tall = (int32_at(a, DOWN) + TILE - 1) // TILE
    step = int32_at(a, CHANNELS)
    rows = TILE + 1 if int32_at(a, DOWN) > 1 else 1
    return (
        j // TILE * wide + i // TILE,
        wide * tall,
        1 + rows * (TILE + 1) * step,
        1 + (j % TILE * (TILE + 1) + i % TILE) * step,
    )


@contracted
def split(a, depth, i, j):
    """(w_B / w_A, which half leads to leaf (i, j)) of the split at a depth on the way there."""
    s = int32_at(a, SCHEDULE) + 3 * depth
    theta, phi = int32_at(a, s + 1), int32_at(a, s + 2)
    if int32_at(a, s) == 0:
        _, ratio = split_below(a, depth, i >> (theta + 1), j >> phi)
        return ratio, i >> theta & 1
    _, ratio = split_below(a, depth, i >> theta, j >> (phi + 1))
    return ratio, j >> phi & 1


@contracted
def split_below(a, depth, i, j):
    """(whether it cuts θ, w_B / w_A) of the split at a depth, below the bits (i, j) so far."""
    s = int32_at(a, SCHEDULE) + 3 * depth
    if int32_at(a, s) == 0:
        k = (1 << (int32_at(a, THETA_BITS) - int32_at(a, s + 1) - 1)) + i
        return True, float32_at(a, int32_at(a, THETA_RATIOS) + k - 1)
    k = (1 << (int32_at(a, PHI_BITS) - int32_at(a, s + 2) - 1)) + j
    return False, float32_at(a, int32_at(a, PHI_RATIOS) + k - 1)


@contracted
def inverse_share(a, level, i, j):
    """1 / the part of the tree's projected solid angle that cell (i, j) of a level has."""
    k = (1 << (int32_at(a, THETA_BITS) - level)) + i
    n = (1 << (int32_at(a, PHI_BITS) - level)) + j
    return float32_at(a, int32_at(a, THETA_SHARES) + k) * float32_at(a, int32_at(a, PHI_SHARES) + n)


@contracted
def tree_place(a, tree, level):
    """(x, y): where a direction lies among the cells of a level; whole numbers are centres."""
    u, v = coordinates(tree)
    symmetry = int32_at(a, SYMMETRY)
    u = 2.0 * u if symmetry == ORTHOTROPIC else u
    v = v if symmetry == GENERAL else 2.0 * v
    columns = 1 << (int32_at(a, THETA_BITS) - level)
    rows = 1 << (int32_at(a, PHI_BITS) - level)
    return u * columns - 0.5, v * rows - 0.5


@njit(error_model="numpy", fastmath={"contract"})
def synthesise(a, wi, wo, level, nearest=False):
    """BRDF (3) in sr⁻¹ for directions above the surface, at a whole level; 0 is the finest.

    With `nearest` it is that of the sample and the cell that are nearest.
    """
    plane, tree = turned(a, wi, wo)
    r, g, b = around(a, plane, tree, level, True, nearest)
    floor = int32_at(a, FLOOR)
    return (
        max(ZERO, r - float32_at(a, floor)),
        max(ZERO, g - float32_at(a, floor + 1)),
        max(ZERO, b - float32_at(a, floor + 2)),
    )


@contracted
def around(a, plane, tree, level, per_share, nearest=False):
    """Bilinear between four cells of a level: what each reflects, or that per share of the tree's
    projected solid angle, which is the mean BRDF in it. The floor is included.

    plane and tree as from `turned`.
    """
    x, y = tree_place(a, tree, level)
    columns = 1 << (int32_at(a, THETA_BITS) - level)
    rows = 1 << (int32_at(a, PHI_BITS) - level)
    depth = int32_at(a, THETA_BITS) + int32_at(a, PHI_BITS) - 2 * level
    taps = plane_taps(a, plane)
    if nearest:
        x, y = _centre_by(x, columns), _centre_by(y, rows)
        taps = taps[0], taps[1], ONE if taps[2] >= 0.5 else ZERO, ONE if taps[3] >= 0.5 else ZERO
    i, j = math.floor(x), math.floor(y)
    fx, fy = np.float32(x - i), np.float32(y - j)
    mirrors = int32_at(a, SYMMETRY) == ORTHOTROPIC
    reflected, nodes = stack_words(SCRATCH), stack_words(NODES)
    store_int(nodes, 0, np.int32(1))
    red, green, blue = ZERO, ZERO, ZERO
    before = (-1, -1, 0)
    for corner in range(4):
        # Once around the square, so that only one coordinate changes at a time.
        di, dj = 1 if corner == 1 or corner == 2 else 0, corner // 2
        weight = (fx if di else ONE - fx) * (fy if dj else ONE - fy)
        if weight <= ZERO:
            continue
        # Beyond an edge lies the mirror image, or nothing.
        ci, cj = min(max(i + di, 0), columns - 1), min(max(j + dj, 0), rows - 1)
        seen = (1 if i + di == columns else 0) | (2 if j + dj == rows else 0) if mirrors else 0
        shared = 0
        if seen != before[2]:
            taps = plane_taps(a, mirrored(plane, seen))
        elif before[0] >= 0:
            shared = _shared(a, level, ci ^ before[0], cj ^ before[1])
        if shared == 0:
            root_at(a, taps, reflected)
        descend(a, taps, ci << level, cj << level, shared, depth, reflected, nodes)
        if per_share:
            weight *= inverse_share(a, level, ci, cj)
        red += weight * load_float(reflected, COUNT * depth)
        green += weight * load_float(reflected, COUNT * depth + 1)
        blue += weight * load_float(reflected, COUNT * depth + 2)
        before = (ci, cj, seen)
    return red, green, blue


@contracted
def _centre_by(x, count):
    """Of the centres 0 to count - 1 that nearest to x."""
    return float(min(max(math.floor(x + 0.5), 0), count - 1))


@contracted
def mirrored(w, which):
    """w with x (bit 0) and y (bit 1) negated."""
    return -w[0] if which & 1 else w[0], -w[1] if which & 2 else w[1], w[2]


@contracted
def _shared(a, level, across, along):
    """Splits that two cells of a level share from the root, from the bits in which they differ."""
    bit, s = level, int32_at(a, SCHEDULE) + 3 * (int32_at(a, THETA_BITS) + int32_at(a, PHI_BITS))
    differ = across | along
    while differ > 1:
        differ >>= 1
        bit += 1
    return int32_at(a, s + 2 * bit + (1 if along else 0))


@contracted
def descend(a, taps, i, j, start, depth, reflected, nodes):
    """Fill what the cells on the way to leaf (i, j) reflect, (depth + 1, COUNT), from `start` on.

    `nodes` gets the number of each, the same way.
    """
    places = tile_places(a, taps)
    node = np.int64(load_int(nodes, start))
    for k in range(start, depth):
        ratio, second = split(a, k, i, j)
        halve(a, node, k, ratio, second != 0, taps, places, reflected)
        node = 2 * node + second
        store_int(nodes, k + 1, np.int32(node))


@contracted
def halve(a, node, depth, ratio, second, taps, places, reflected):
    """Write what one half of a node reflects, after what the node does at its depth.

    ratio is that of the weights of the second half and the first.
    """
    tile, tiles, octets, first = places
    row, number = np.int64(uint16_at(a, int32_at(a, MAP) + node - 1)), 0
    if row > 0:
        number = np.int64(uint16_at(a, int32_at(a, FIRST_ROW) + (row - 1) * tiles + tile))
    p = COUNT * depth
    if number == 0:
        part = (ratio if second else ONE) / (ONE + ratio)
        for c in range(COUNT):
            store_float(reflected, p + COUNT + c, load_float(reflected, p + c) * part)
        return
    _, _, fx, fy = taps
    channels = np.int64(int32_at(a, CHANNELS))
    q = int32_at(a, FIRST_TILE) + (number - 1) * octets
    scale = np.float32(uint8_at(a, q))
    step = scale * scale * float32_at(a, int32_at(a, RANGES) + depth)
    below = (TILE + 1) * channels if int32_at(a, DOWN) > 1 else 0
    go_down(
        reflected + np.uint64(4 * p), a + np.uint64(q + first), channels, below, step, fx, fy,
        ratio, channels == 1, second,
    )  # fmt: skip
