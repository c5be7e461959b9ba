"""What matt surfaces receive: smooth but for edges, and so shared by neighbouring pixels.

Pixels of a block of 8 x 8 have other rays each (`patterns`), so that their mean over a window of
that size has 64 times as many: interleaved sampling with a discontinuity buffer (Keller and
Heidrich 2001). Only pixels of the same surface share. It is for light that surfaces send, not for
that of lamps, whose shadows are sharp; and for caustics, which few of a pixel's rays find.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.brdf_editing.arriving import (
    Arriving,
    Even,
    Surface,
    add_lanes,
    bring_rest,
    is_matt_light,
)
from engine.methods.brdf_editing.links import BEYOND
from engine.methods.brdf_editing.patterns import SIDE, pattern_of, room_for
from engine.methods.brdf_editing.second import add_behind
from engine.methods.interrupt import pieces
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_local
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, sub, vec

WIDTHS = 64  # of how far the window reaches, at least, in a picture: large pixels blur
SAME_NORMAL = 0.9  # cosine between normals of one surface
PIECE = 65536  # pixels that are gathered for in a tenth of a second
SAME_PLANE = 2.0  # widths of a pixel that a neighbour may lie above or below


def shared(
    surface: Surface, arriving: Arriving, hand: int, pixels: NDArray[np.int32], scale: int
) -> Even:
    """What reaches the centres of pixels (k,), and of those whose rays they take; 0 elsewhere.

    Of every scale-th ray: small pictures are looked at for a moment.
    """
    n, degrees, slots = len(surface.edge), arriving.powers.shape[1], arriving.second.slots
    edge = surface.edge[pixels]
    there = np.zeros(n, np.bool_)
    there[pixels] = there[surface.donor.reshape(-1, 4)[edge[edge >= 0]]] = True
    there &= surface.model[:n] >= 0
    some = np.flatnonzero(there).astype(np.int32)
    light = np.zeros((n, degrees, 3), np.float32)
    behind = np.zeros((n, degrees, 3, slots), np.float32)
    for piece in pieces(len(some), PIECE):
        args = surface, arriving, hand, some[piece], scale, light, behind
        for_ranges(_gather, piece.stop - piece.start, *args, grain=64)
    rows = np.concatenate([light.reshape(n, -1), behind.reshape(n, -1)], axis=1)
    reach = min(
        SIDE // 2, arriving.width // WIDTHS
    )  # blurs less than a block where pixels are large
    for step in (1, arriving.width):
        out = np.zeros_like(rows)
        for_ranges(
            _smooth, len(some), surface, hand, arriving.width, step, reach, some, there, rows, out,
            grain=256,
        )  # fmt: skip
        rows = out
    light, behind = (np.ascontiguousarray(a) for a in np.split(rows, [3 * degrees], axis=1))
    return Even(light.reshape(n, degrees, 3), behind.reshape(n, degrees, 3, slots))


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _gather(begin, end, surface, arriving, hand, some, step, even, behind):
    surface, arriving = borrow(surface), borrow(arriving)
    cosines, degrees = arriving.patterns.cosines, even.shape[1]
    kind, brought, lit = arriving.second.kind, arriving.rows, arriving.beyond.shape[0] > 0
    count = -(-cosines // step)
    share = np.float32(1.0 / count)
    work = (
        room_for(count),
        np.zeros((count, brought.shape[1]), np.float32),
        np.full((3, count), share, np.float32),
    )
    total = np.zeros(brought.shape[1], np.float32)
    for q in range(begin, end):
        i = some[q]
        sample, rest = arriving.sample[i], 0
        total[:] = 0.0
        # These rays count alike, so that no direction need be known but of those that leave the
        # scene, or meet gloss.
        for k in range(0, cosines, step):
            y = sample[k]
            if is_matt_light(kind, y):
                add_lanes(total, share, brought[y])
            elif y != BEYOND or lit:
                rest += 1
        if rest > 0:
            _gather_rest(surface, arriving, hand, i, step, share, work, total, behind[i])
        for n in range(degrees):
            for c in range(3):
                even[i, n, c] = total[3 * n + c]


@njit(fastmath={"contract", "reassoc"})
def _gather_rest(surface, arriving, hand, i, step, share, work, total, behind):
    """Add what comes from gloss and from beyond the scene, each ray with a share."""
    rays, room, weight = work
    sample, kind = arriving.sample[i], arriving.second.kind
    z, g = vec(surface.normal, i), vec(surface.geometric, i)
    s, t = tangents(z)
    count = room.shape[0]
    _directions(arriving, i, count, step, to_local(g, s, t, z), rays)
    apart = behind.shape[2] > 0 and surface.material[i] != hand
    bring_rest(arriving, sample, rays, count, 0, step, (s, t, z), apart, room)
    for r in range(count):
        if rays.z[r] > 0.0 and not is_matt_light(kind, sample[r * step]):
            add_lanes(total, share, room[r])
    if apart:
        add_behind(arriving.second, sample, rays, count, 0, step, (s, t, z), weight, behind)


@njit
def _directions(arriving, i, count, step, g, rays):
    """Fill in every step-th of a pixel's rays."""
    local = arriving.patterns.local[pattern_of(i, arriving.width)]
    for r in range(count):
        w = local[0, r * step], local[1, r * step], local[2, r * step]
        rays.x[r], rays.y[r] = w[0], w[1]
        rays.z[r] = w[2] if dot(w, g) > 0.0 else -1.0


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _smooth(begin, end, surface, hand, width, step, reach, some, there, rows, out):
    """Means over `reach` pixels to either side along a row (step 1) or column (step width)."""
    surface = borrow(surface)
    for r in range(begin, end):
        i, total = some[r], 0.0
        place = i % width if step == 1 else i // width
        most = width if step == 1 else surface.edge.shape[0] // width
        for side in range(-reach, reach + 1):
            j = i + side * step
            if place + side < 0 or place + side >= most or not there[j]:
                continue
            if not _alike(surface, hand, i, j):
                continue
            # Ends count half, so that each of the SIDE lattices counts once.
            weight = np.float32(0.5 if abs(side) == reach else 1.0)
            total += weight
            for q in range(rows.shape[1]):
                out[i, q] += weight * rows[j, q]
        for q in range(rows.shape[1]):
            out[i, q] /= np.float32(total)


@njit
def _alike(surface, hand, i, j):
    if (surface.material[i] == hand) != (surface.material[j] == hand):
        return False
    n = vec(surface.normal, i)
    if dot(n, vec(surface.normal, j)) < SAME_NORMAL:
        return False
    away = sub(vec(surface.position, j), vec(surface.position, i))
    far = abs(dot(n, away))
    return far < SAME_PLANE * max(surface.size[i], surface.size[j])
