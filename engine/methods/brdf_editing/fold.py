"""Freezing: what comes along the rays, sorted by the elements of the basis or reflected at once.

`brdf_editing` (Ben-Artzi et al. 2008), eq. 27: for pixels of the material in hand

    F_jn(x) = Σ_rays over those of element j    q(wi, wo) cos θ / p · R_n    + direct light at n = 0

and for all others, whose coefficients stand, the sums V_n over j. R_n are powers of the light on
the cloud, see `polynomial`. A pixel at an edge has four parts, of one material or another, and each
takes a quarter of the rays.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.curve_basis import weights_at
from engine.brdf.layers import CONSTANTS, CURVES, factors_along
from engine.methods.brdf_editing.arriving import (
    Arriving,
    Surface,
    add_even,
    add_lanes,
    aim,
    bring_rest,
    fetch,
    part_of,
)
from engine.methods.brdf_editing.light_seen import MOST, lamp_rays
from engine.methods.brdf_editing.patterns import room_for
from engine.methods.interrupt import pieces
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec

STEPS = 32767
PIECE = 4096  # pixels that are folded in less than a tenth of a second


class Folded(NamedTuple):
    """F of m pixels, in sixteen bits.

    steps  (m, deg + 1, 3, slots) int16   constants first, then curve by curve
    unit   (m, deg + 1) float32           of a step
    """

    steps: NDArray[np.int16]
    unit: NDArray[np.float32]


class Slots(NamedTuple):
    """How a material is cut, and the elements of a curve.

    cut                which of LAYERS
    constants, curves  how many of each that has
    bands, tents       how many elements a curve has, and which they are
    """

    cut: int
    constants: int
    curves: int
    bands: int
    tents: bool

    @property
    def every(self) -> int:
        """Number of all coefficients."""
        return self.constants + self.curves * self.bands


def fold(
    surface: Surface, arriving: Arriving, pixels: NDArray[np.int32], hand: int, slots: Slots
) -> Folded:
    """F of pixels (m,), for what they show of the material `hand`."""
    degrees = arriving.powers.shape[1]
    out = Folded(
        np.zeros((len(pixels), degrees, 3, slots.every), np.int16),
        np.zeros((len(pixels), degrees), np.float32),
    )
    for piece in pieces(len(pixels), PIECE):
        args = surface, arriving, pixels[piece], hand, slots
        part = out.steps[piece], out.unit[piece]
        for_ranges(_fold, piece.stop - piece.start, *args, *part, grain=64)
    return out


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _fold(begin, end, surface, arriving, pixels, hand, slots, steps, unit):
    surface, arriving = borrow(surface), borrow(arriving)
    degrees, lanes = steps.shape[1], arriving.rows.shape[1]
    total = np.zeros((steps.shape[3], lanes), np.float32)
    part_of_it, most = np.zeros_like(total), max(MOST, arriving.sample.shape[1])
    work = (
        room_for(most),
        np.zeros((most, lanes), np.float32),
        np.zeros((1 + CONSTANTS + CURVES, most)),
    )
    is_even = arriving.matt[hand, 0] >= 0.0
    for q in range(begin, end):
        total[:] = 0.0
        i = pixels[q]
        parts = 4 if surface.edge[i] >= 0 else 1
        for part in range(parts):
            at, link = part_of(surface, i, part)
            if surface.material[at] != hand:
                continue
            if is_even:
                even = total[0, : 3 * degrees].reshape(degrees, 3)
                add_even(arriving, link, parts, vec(surface.texture, at), even)
            if slots.curves > 0 or not is_even:
                first = 1 if is_even else 0
                part_of_it[:] = 0.0
                _fold_rays(surface, arriving, at, link, part, parts, slots, first, work, part_of_it)
                _add_textured(surface, at, slots, degrees, part_of_it, total)
            else:
                for c in range(3):
                    lit = surface.texture[at, c] * arriving.direct[at, c]
                    total[0, c] += lit / np.float32(parts)
        to_steps(total, steps[q], unit[q])


@njit(fastmath={"contract", "reassoc"})
def _fold_rays(surface, arriving, at, link, part, parts, slots, first, work, total):
    """Add what rays bring, and lamps: of a pixel's own rays to the quotients from `first` on."""
    rays, room, quotients = work
    p = surface.row[at]
    sample = arriving.sample[link]
    count, frame, wo = aim(surface, arriving, at, link, part, parts, rays)
    fetch(arriving.rows, sample, part, parts, room)
    bring_rest(arriving, sample, rays, count, part, parts, frame, False, room)
    _add(p, rays, count, wo, room, slots, first, quotients, total)
    for lamp in range(arriving.lights.kind.shape[0]):
        count = lamp_rays(
            surface, arriving.lights, arriving.seen, at, lamp, parts, frame, rays, room
        )
        _add(p, rays, count, wo, room, slots, 0, quotients, total)


@njit(fastmath={"contract", "reassoc"})
def _add(p, rays, count, wo, room, slots, first, f, total):
    """Add what the quotients from `first` on make of rays with light `room`: (slots, lanes)."""
    factors_along(slots.cut, p, rays.x, rays.y, rays.z, count, wo, f)
    for q in range(count):
        weight, came = rays.weight[q], room[q]
        if weight <= 0.0:
            continue
        for c in range(first, slots.constants):
            add_lanes(total[c], weight * f[1 + c, q], came)
        if slots.curves > 0:
            j, here, there = weights_at(f[0, q], slots.bands, slots.tents)
            for c in range(slots.curves):
                slot = slots.constants + c * slots.bands + j
                value = weight * f[1 + CONSTANTS + c, q]
                add_lanes(total[slot], value * here, came)
                if there > 0.0:
                    add_lanes(total[slot + 1], value * there, came)


@njit
def _add_textured(surface, at, slots, degrees, found, total):
    """Add what a part of a pixel found: constants and the first curve times its textures."""
    diffuse, gloss, first = surface.texture[at], surface.gloss[at], slots.constants
    for slot in range(found.shape[0]):
        if slot < first:
            for k in range(3 * degrees):
                total[slot, k] += diffuse[k % 3] * found[slot, k]
        elif slot < first + slots.bands:
            for k in range(3 * degrees):
                total[slot, k] += gloss[k % 3] * found[slot, k]
        else:
            add_lanes(total[slot], 1.0, found[slot])


@njit
def to_steps(total, steps, unit):
    """Write down a total (slots, 3 (deg + 1) or more) as `Folded` has it."""
    for n in range(steps.shape[0]):
        most = np.float32(0)
        for slot in range(total.shape[0]):
            for channel in range(3):
                most = max(most, abs(total[slot, 3 * n + channel]))
        unit[n] = most / np.float32(STEPS)
        inverse = np.float32(STEPS) / most if most > 0.0 else np.float32(0)
        for slot in range(total.shape[0]):
            for channel in range(3):
                steps[n, channel, slot] = math.floor(total[slot, 3 * n + channel] * inverse + 0.5)
