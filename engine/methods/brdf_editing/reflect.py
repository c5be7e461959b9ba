"""What pixels reflect whose coefficients stand: V of `brdf_editing` (Ben-Artzi et al.), §5.2."""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdfs
from engine.brdf.base import DIFFUSE, is_matt
from engine.methods.brdf_editing.arriving import (
    Arriving,
    Surface,
    came_along,
    from_lamp,
    gather_even,
    part_of,
)
from engine.methods.brdf_editing.light_seen import Shining
from engine.methods.brdf_editing.patterns import pattern_of, ray_of, weight_of
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_local
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, vec

evaluate = brdfs.evaluate


def reflect(surface: Surface, arriving: Arriving, hand: int) -> NDArray[np.float32]:
    """V of all n pixels, for what they show of other materials: (n, deg + 1, 3) float32."""
    out = np.zeros((len(surface.edge), arriving.powers.shape[1], 3), np.float32)
    for_ranges(_reflect, len(out), surface, arriving, hand, out, grain=64)
    return out


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _reflect(begin, end, surface, arriving, hand, out):
    surface, arriving = borrow(surface), borrow(arriving)
    none = np.zeros((out.shape[1], 3), np.float32)
    even = np.zeros((out.shape[1], 3), np.float32)
    for i in range(begin, end):
        parts = 4 if surface.edge[i] >= 0 else 1
        for part in range(parts):
            at, link = part_of(surface, i, part)
            if surface.model[at] < 0 or surface.material[at] == hand:
                continue
            if is_matt(surface.row[at]) and arriving.patterns.cosines > 0:
                gather_even(surface, arriving, at, link, part, parts, none, even)
                for c in range(3):
                    out[i, :, c] += surface.row[at, DIFFUSE + c] * even[:, c]
            else:
                _reflect_rays(surface, arriving, at, link, part, parts, none, out[i])
                _reflect_lights(surface, arriving, at, parts, out[i, 0])


@njit(fastmath={"contract", "reassoc"})
def _reflect_rays(surface, arriving, at, link, part, parts, none, out):
    p, model = surface.row[at], surface.model[at]
    z, g = vec(surface.normal, at), vec(surface.geometric, at)
    s, t = tangents(z)
    wo = to_local(vec(surface.eye, at), s, t, z)
    pattern, patterns = pattern_of(link, arriving.width), arriving.patterns
    sample, powers, beyond = arriving.sample[link], arriving.powers, arriving.beyond
    for k in range(part, sample.shape[0], parts):
        wi, d = ray_of(patterns, pattern, k, wo, (s, t, z), g)
        if wi[2] <= 0.0:
            continue
        came = came_along(powers, beyond, sample[k], d, none)
        weight = weight_of(patterns, wi, wo)
        f = evaluate(model, p, wi, wo)
        for n in range(out.shape[0]):
            for c in range(3):
                out[n, c] += weight * f[c] * came[n, c]


@njit(fastmath={"contract", "reassoc"})
def _reflect_lights(surface, arriving, at, parts, out):
    p, model, z = surface.row[at], surface.model[at], vec(surface.normal, at)
    lights = arriving.lights
    s, t = tangents(z)
    wo = to_local(vec(surface.eye, at), s, t, z)
    for lamp in range(lights.kind.shape[0]):
        bits, count = arriving.seen[at, lamp], lights.points[lamp]
        for k in range(count):
            if (bits >> np.uint64(k)) & np.uint64(1) == 0:
                continue
            w, light = from_lamp(surface, lights, at, lamp, k)
            wi = to_local(w, s, t, z)
            if wi[2] <= 0.0:
                continue
            f = evaluate(model, p, wi, wo)
            for c in range(3):
                out[c] += wi[2] / (count * parts) * f[c] * light[c]


def direct_of(surface: Surface, lights: Shining, seen: NDArray[np.uint64]) -> NDArray[np.float32]:
    """(n + 4 m, 3) float32: irradiance over π by the lights themselves."""
    out = np.zeros((len(surface.model), 3), np.float32)
    for_ranges(_irradiance, len(out), surface, lights, seen, out, grain=256)
    return out


@njit(cache=True, nogil=True)
def _irradiance(begin, end, surface, lights, seen, out):
    surface, lights = borrow(surface), borrow(lights)
    for at in range(begin, end):
        n = vec(surface.normal, at)
        for lamp in range(lights.kind.shape[0]):
            bits, count = seen[at, lamp], lights.points[lamp]
            for k in range(count):
                if (bits >> np.uint64(k)) & np.uint64(1) == 0:
                    continue
                w, light = from_lamp(surface, lights, at, lamp, k)
                cosine = max(0.0, dot(n, w)) / (count * math.pi)
                for c in range(3):
                    out[at, c] += cosine * light[c]
