"""What gloss sends to the matt part of pixels: smooth but for edges, and so shared by neighbours.

A sharp lobe behind the first bounce makes a caustic, which few of a pixel's rays find. Pixels of a
block of 8 x 8 have other rays each (`patterns`), so that their mean over a window of that size has
64 times as many: interleaved sampling with a discontinuity buffer (Keller and Heidrich 2001). Only
pixels of the same surface share.
"""

from __future__ import annotations

import numpy as np
from numba import njit

from engine.methods.brdf_editing.arriving import (
    Apart,
    Arriving,
    Surface,
    came_along,
    came_apart,
    is_gloss,
)
from engine.methods.brdf_editing.patterns import SIDE, pattern_of
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_world
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, sub, vec

REACH = SIDE // 2
SAME_NORMAL = 0.9  # cosine between normals of one surface
SAME_PLANE = 2.0  # widths of a pixel that a neighbour may lie above or below


def shared(surface: Surface, arriving: Arriving, hand: int) -> Apart:
    """What reaches pixels that are not at edges, and nothing at the others."""
    n, degrees, slots = len(surface.edge), arriving.powers.shape[1], arriving.second.slots
    even = np.zeros((n, degrees, 3), np.float32)
    behind = np.zeros((n, degrees, slots, 3), np.float32)
    for_ranges(_gather, n, surface, arriving, hand, even, behind, grain=64)
    rows = np.concatenate([even[:, :, None], behind], axis=2).reshape(n, -1)
    for step in (1, arriving.width):
        out = np.zeros_like(rows)
        for_ranges(_smooth, n, surface, hand, arriving.width, step, rows, out, grain=256)
        rows = out
    found = rows.reshape(n, degrees, slots + 1, 3)
    return Apart(np.ascontiguousarray(found[:, :, 0]), np.ascontiguousarray(found[:, :, 1:]))


@njit(cache=True, nogil=True)
def _gather(begin, end, surface, arriving, hand, even, behind):
    surface, arriving = borrow(surface), borrow(arriving)
    cosines = arriving.patterns.cosines
    room = np.zeros((even.shape[1], 3), np.float32)
    share = 1.0 / max(1, cosines)
    for i in range(begin, end):
        if surface.edge[i] >= 0 or surface.model[i] < 0:
            continue
        z, g = vec(surface.normal, i), vec(surface.geometric, i)
        s, t = tangents(z)
        pattern = pattern_of(i, arriving.width)
        for k in range(cosines):
            y = arriving.sample[i, k]
            if not is_gloss(arriving, y):
                continue
            d = to_world(vec(arriving.patterns.local[pattern], k), s, t, z)
            if dot(d, g) <= 0.0:
                continue
            if surface.material[i] == hand:
                came = came_along(arriving, y, d, k, room)
            else:
                came = came_apart(arriving, y, d, k, (share, share, share), room, behind[i])
            for n in range(even.shape[1]):
                for c in range(3):
                    even[i, n, c] += share * came[n, c]


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _smooth(begin, end, surface, hand, width, step, rows, out):
    """Means over REACH pixels to either side along a row (step 1) or column (step width)."""
    surface = borrow(surface)
    for i in range(begin, end):
        if surface.edge[i] >= 0 or surface.model[i] < 0:
            continue
        total = 0.0
        place = i % width if step == 1 else i // width
        most = width if step == 1 else surface.edge.shape[0] // width
        for side in range(-REACH, REACH + 1):
            j = i + side * step
            if place + side < 0 or place + side >= most or not _alike(surface, hand, i, j):
                continue
            # Ends count half, so that each of the SIDE lattices counts once.
            weight = np.float32(0.5 if abs(side) == REACH else 1.0)
            total += weight
            for q in range(rows.shape[1]):
                out[i, q] += weight * rows[j, q]
        for q in range(rows.shape[1]):
            out[i, q] /= np.float32(total)


@njit
def _alike(surface, hand, i, j):
    if surface.edge[j] >= 0 or surface.model[j] < 0:
        return False
    if (surface.material[i] == hand) != (surface.material[j] == hand):
        return False
    n = vec(surface.normal, i)
    if dot(n, vec(surface.normal, j)) < SAME_NORMAL:
        return False
    away = sub(vec(surface.position, j), vec(surface.position, i))
    far = abs(dot(n, away))
    return far < SAME_PLANE * max(surface.size[i], surface.size[j])
