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
from engine.brdf.layers import CONSTANTS, factors
from engine.methods.brdf_editing.arriving import (
    Arriving,
    Surface,
    add_even,
    add_lanes,
    came_along,
    fetch,
    is_matt_light,
    part_of,
)
from engine.methods.brdf_editing.light_seen import from_lamp
from engine.methods.brdf_editing.patterns import pattern_of, ray_of, weight_of
from engine.methods.interrupt import pieces
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_local
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
    """Numbers of a model's constants and curves, of the elements of a curve, and which they are."""

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
    room = np.zeros((arriving.sample.shape[1], lanes), np.float32)
    one, part_of_it = np.zeros((degrees, 3), np.float32), np.zeros_like(total)
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
                fetch(arriving.rows, arriving.sample[link], part, parts, room)
                _fold_rays(
                    surface, arriving, at, link, part, parts, slots, first, one, room, part_of_it
                )
                _fold_lights(surface, arriving, at, parts, slots, room[0], part_of_it)
                _add_textured(surface, at, slots, degrees, part_of_it, total)
            else:
                for c in range(3):
                    lit = surface.texture[at, c] * arriving.direct[at, c]
                    total[0, c] += lit / np.float32(parts)
        to_steps(total, steps[q], unit[q])


@njit(fastmath={"contract", "reassoc"})
def _fold_rays(surface, arriving, at, link, part, parts, slots, first, one, room, total):
    p, model = surface.row[at], surface.model[at]
    z, g = vec(surface.normal, at), vec(surface.geometric, at)
    s, t = tangents(z)
    wo = to_local(vec(surface.eye, at), s, t, z)
    pattern, patterns = pattern_of(link, arriving.width), arriving.patterns
    sample, kind = arriving.sample[link], arriving.second.kind
    for k in range(part, sample.shape[0], parts):
        wi, d = ray_of(patterns, pattern, k, wo, (s, t, z), g)
        if wi[2] <= 0.0:
            continue
        came = room[k]
        if not is_matt_light(kind, sample[k]):
            rest = came_along(arriving, sample[k], d, k, one)
            for n in range(one.shape[0]):
                for c in range(3):
                    came[3 * n + c] = rest[n, c]
        f, weight = factors(model, p, wi, wo), weight_of(patterns, wi, wo)
        _add(total, f, weight, came, slots, first)


@njit(fastmath={"contract", "reassoc"})
def _fold_lights(surface, arriving, at, parts, slots, came, total):
    """Add what the lights send, which is light of degree 0 in a row `came` (lanes,)."""
    p, model, z = surface.row[at], surface.model[at], vec(surface.normal, at)
    lights = arriving.lights
    s, t = tangents(z)
    wo = to_local(vec(surface.eye, at), s, t, z)
    came[:] = 0.0
    for lamp in range(lights.kind.shape[0]):
        bits, count = arriving.seen[at, lamp], lights.points[lamp]
        for k in range(count):
            if (bits >> np.uint64(k)) & np.uint64(1) == 0:
                continue
            w, light = from_lamp(surface, lights, at, lamp, k)
            wi = to_local(w, s, t, z)
            if wi[2] <= 0.0:
                continue
            for c in range(3):
                came[c] = light[c]
            _add(total, factors(model, p, wi, wo), wi[2] / (count * parts), came, slots, 0)


@njit(inline="always")
def _add(total, f, weight, came, slots, first):
    """Add light times a weight to what the quotients f take from the first on, (slots, lanes)."""
    for c in range(first, slots.constants):
        add_lanes(total[c], weight * f[1 + c], came)
    if slots.curves > 0:
        j, here, there = weights_at(f[0], slots.bands, slots.tents)
        for c in range(slots.curves):
            slot, value = slots.constants + c * slots.bands + j, weight * f[1 + CONSTANTS + c]
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
