"""What pixels reflect whose coefficients stand: V of `brdf_editing` (Ben-Artzi et al.), §5.2."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdfs
from engine.brdf.base import is_matt
from engine.methods.brdf_editing.arriving import (
    Arriving,
    Surface,
    add_even,
    aim,
    bring_rest,
    fetch,
    part_of,
)
from engine.methods.brdf_editing.fold import PIECE, Folded, to_steps
from engine.methods.brdf_editing.light_seen import MOST, lamp_rays
from engine.methods.brdf_editing.patterns import room_for
from engine.methods.brdf_editing.second import add_behind
from engine.methods.interrupt import pieces
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec

evaluate_along = brdfs.evaluate_along


def reflect(
    surface: Surface, arriving: Arriving, hand: int, pixels: NDArray[np.int32]
) -> tuple[NDArray[np.float32], Folded]:
    """V of n pixels, for what they show of other materials: (n, deg + 1, 3) float32.

    It is found for `pixels`, and 0 for others.

    And F of the coefficients that the second bounce has of the material in hand, see `second`.
    """
    n, degrees, slots = len(surface.edge), arriving.powers.shape[1], arriving.second.slots
    out = np.zeros((n, degrees, 3), np.float32)
    behind = Folded(
        np.zeros((n if slots else 0, degrees, 3, slots), np.int16),
        np.zeros((n if slots else 0, degrees), np.float32),
    )
    for piece in pieces(len(pixels), PIECE):
        args = surface, arriving, hand, pixels[piece], slots, out, *behind
        for_ranges(_reflect, piece.stop - piece.start, *args, grain=64)
    return out, behind


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _reflect(begin, end, surface, arriving, hand, pixels, slots, out, steps, unit):
    surface, arriving = borrow(surface), borrow(arriving)
    most = max(MOST, arriving.sample.shape[1])
    work = (
        room_for(most),
        np.zeros((most, arriving.rows.shape[1]), np.float32),
        np.zeros((3, most)),
    )
    behind = np.zeros((out.shape[1], 3, slots), np.float32)
    for q in range(begin, end):
        i = pixels[q]
        behind[:] = 0.0
        parts = 4 if surface.edge[i] >= 0 else 1
        for part in range(parts):
            at, link = part_of(surface, i, part)
            if surface.model[at] < 0 or surface.material[at] == hand:
                continue
            matt, texture = vec(arriving.matt, surface.material[at]), vec(surface.texture, at)
            colour = (0.0, 0.0, 0.0)
            if matt[0] >= 0.0:
                colour = (matt[0] * texture[0], matt[1] * texture[1], matt[2] * texture[2])
                add_even(arriving, link, parts, colour, out[i])
                _add_behind(arriving, link, parts, colour, behind)
            if is_matt(surface.row[at]) and matt[0] >= 0.0:
                for c in range(3):
                    out[i, 0, c] += colour[c] * arriving.direct[at, c] / np.float32(parts)
            else:
                _reflect_rays(
                    surface, arriving, at, link, part, parts, colour, work, behind, out[i]
                )
        if slots > 0:
            to_steps(behind.reshape(-1, slots).T, steps[i], unit[i])


@njit
def _add_behind(arriving, link, parts, colour, behind):
    for c in range(3):
        share = np.float32(colour[c] / parts)
        for n in range(behind.shape[0]):
            for slot in range(behind.shape[2]):
                behind[n, c, slot] += share * arriving.even.behind[link, n, c, slot]


@njit(fastmath={"contract", "reassoc"})
def _reflect_rays(surface, arriving, at, link, part, parts, colour, work, behind, out):
    """Add what rays bring, but for what a matt surface of the colour reflects, and lamps."""
    rays, room, f = work
    apart = behind.shape[2] > 0
    p, model = surface.row[at], surface.model[at]
    sample = arriving.sample[link]
    count, frame, wo = aim(surface, arriving, at, link, part, parts, rays)
    fetch(arriving.rows, sample, part, parts, room)
    bring_rest(arriving, sample, rays, count, part, parts, frame, apart, room)
    evaluate_along(model, p, rays.x, rays.y, rays.z, count, wo, f)
    for q in range(count):
        weight = rays.weight[q]
        for c in range(3):
            f[c, q] = weight * (f[c, q] - colour[c] / math.pi) if weight > 0.0 else 0.0
    for q in range(count):
        if rays.weight[q] > 0.0:
            for n in range(out.shape[0]):
                for c in range(3):
                    out[n, c] += f[c, q] * room[q, 3 * n + c]
    if apart:
        add_behind(arriving.second, sample, rays, count, part, parts, frame, f, behind)
    for lamp in range(arriving.lights.kind.shape[0]):
        count = lamp_rays(
            surface, arriving.lights, arriving.seen, at, lamp, parts, frame, rays, room
        )
        evaluate_along(model, p, rays.x, rays.y, rays.z, count, wo, f)
        for q in range(count):
            for c in range(3):
                out[0, c] += rays.weight[q] * f[c, q] * room[q, c]
