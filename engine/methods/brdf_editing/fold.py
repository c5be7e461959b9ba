"""Freezing: what comes along the rays, sorted by the elements of the basis or reflected at once.

`brdf_editing` (Ben-Artzi et al. 2008), eq. 27: for pixels of the material in hand

    F_jn(x) = Σ_rays over those of element j    q(wi, wo) cos θ / p · R_n    + direct light at n = 0

and for all others, whose coefficients stand, the sums V_n over j. R_n are powers of the light on
the cloud, see `polynomial`. A pixel at an edge has four parts, of one material or another, and each
takes a quarter of the rays.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdfs
from engine.brdf.curve_basis import weights_at
from engine.brdf.layers import CONSTANTS, factors
from engine.light import table as lights
from engine.light.environment_samples import DEPTH
from engine.methods.brdf_editing.light_seen import Shining
from engine.methods.brdf_editing.links import BEYOND
from engine.methods.brdf_editing.patterns import Patterns, incident, pattern_of, weight_of
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_local, to_world
from engine.numerics.octahedron import cell as cell_of
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, vec

evaluate, illuminate = brdfs.evaluate, lights.illuminate
STEPS = 32767


class Arriving(NamedTuple):
    """The light that folds take.

    patterns, width   which rays a pixel has
    sample            (n, N) uint16 what they meet
    powers            (n_g, deg + 1, 3) float32
    beyond            (4^DEPTH, 3) float32 radiance of the environment; (0, 3) for none
    lights            those that shine
    seen              (n + 4 m, l) uint64 which of their points are seen
    """

    patterns: Patterns
    width: int
    sample: NDArray[np.uint16]
    powers: NDArray[np.float32]
    beyond: NDArray[np.float32]
    lights: Shining
    seen: NDArray[np.uint64]


class Surface(NamedTuple):
    """n pixels and the 4 m sub-samples of those at edges, one behind the other; see `FrameBuffer`.

    position, normal, geometric, size  as of `Points`, and eye, its view
    material, model, row  (n + 4 m,) as materials are now, row with their textures
    texture (n + 4 m, 3)  factor of the diffuse reflectance
    edge    (n,) int32    which of the m edge pixels each is, -1 for none
    donor   (4 m,) int32  the pixel whose rays a sub-sample takes
    """

    position: NDArray[np.float32]
    normal: NDArray[np.float32]
    geometric: NDArray[np.float32]
    eye: NDArray[np.float32]
    size: NDArray[np.float32]
    material: NDArray[np.int32]
    model: NDArray[np.int32]
    row: NDArray[np.float32]
    texture: NDArray[np.float32]
    edge: NDArray[np.int32]
    donor: NDArray[np.int32]


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
    for_ranges(_fold, len(pixels), surface, arriving, pixels, hand, slots, *out, grain=64)
    return out


def reflect(surface: Surface, arriving: Arriving, hand: int) -> NDArray[np.float32]:
    """V of all n pixels, for what they show of other materials: (n, deg + 1, 3) float32."""
    out = np.zeros((len(surface.edge), arriving.powers.shape[1], 3), np.float32)
    for_ranges(_reflect, len(out), surface, arriving, hand, out, grain=64)
    return out


@njit
def _part(surface, i, part):
    """(point, pixel whose rays it takes) of a part of pixel i."""
    e = surface.edge[i]
    if e < 0:
        return i, i
    return surface.edge.shape[0] + 4 * e + part, surface.donor[4 * e + part]


@njit
def _came(arriving, sample, d, none):
    """Radiance along a ray, (deg + 1, 3): of the cloud, or of the environment."""
    if sample != BEYOND:
        return arriving.powers[sample]
    none[0] = 0.0
    if arriving.beyond.shape[0] > 0:
        none[0] = arriving.beyond[cell_of(d, DEPTH)]
    return none


@njit
def _light(surface, light, at, lamp, k):
    """(direction, radiance times solid angle) of point k of a light, as seen from a surface."""
    wx, wy, wz, _, red, green, blue = illuminate(
        light.kind[lamp], light.row[lamp], light.texels, vec(surface.position, at),
        np.float64(surface.size[at]), light.place[lamp, k, 0], light.place[lamp, k, 1],
    )  # fmt: skip
    return (wx, wy, wz), (red, green, blue)


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _fold(begin, end, surface, arriving, pixels, hand, slots, steps, unit):
    surface, arriving = borrow(surface), borrow(arriving)
    total = np.zeros((steps.shape[1], steps.shape[3], 3), np.float32)
    none = np.zeros((steps.shape[1], 3), np.float32)
    for q in range(begin, end):
        total[:] = 0.0
        i = pixels[q]
        parts = 4 if surface.edge[i] >= 0 else 1
        for part in range(parts):
            at, link = _part(surface, i, part)
            if surface.material[at] == hand:
                _fold_rays(surface, arriving, at, link, part, parts, slots, none, total)
                _fold_lights(surface, arriving, at, parts, slots, total)
        _to_steps(total, steps[q], unit[q])


@njit(fastmath={"contract", "reassoc"})
def _fold_rays(surface, arriving, at, link, part, parts, slots, none, total):
    p, model = surface.row[at], surface.model[at]
    z, g = vec(surface.normal, at), vec(surface.geometric, at)
    s, t = tangents(z)
    wo, texture = to_local(vec(surface.eye, at), s, t, z), vec(surface.texture, at)
    pattern = pattern_of(link, arriving.width)
    for k in range(part, arriving.sample.shape[1], parts):
        wi = incident(arriving.patterns, pattern, k, wo)
        if wi[2] <= 0.0:
            continue
        d = to_world(wi, s, t, z)
        if dot(d, g) <= 0.0:
            continue
        came = _came(arriving, arriving.sample[link, k], d, none)
        f = factors(model, p, wi, wo)
        weight = weight_of(arriving.patterns, wi, wo)
        for n in range(total.shape[0]):
            light = (came[n, 0], came[n, 1], came[n, 2])
            _add(total[n], f, weight, light, texture, slots)


@njit(fastmath={"contract", "reassoc"})
def _fold_lights(surface, arriving, at, parts, slots, total):
    p, model, z = surface.row[at], surface.model[at], vec(surface.normal, at)
    lights = arriving.lights
    s, t = tangents(z)
    wo, texture = to_local(vec(surface.eye, at), s, t, z), vec(surface.texture, at)
    for lamp in range(lights.kind.shape[0]):
        bits, count = arriving.seen[at, lamp], lights.points[lamp]
        for k in range(count):
            if (bits >> np.uint64(k)) & np.uint64(1) == 0:
                continue
            w, light = _light(surface, lights, at, lamp, k)
            wi = to_local(w, s, t, z)
            if wi[2] > 0.0:
                f, weight = factors(model, p, wi, wo), wi[2] / (count * parts)
                _add(total[0], f, weight, light, texture, slots)


@njit(inline="always")
def _add(total, f, weight, light, texture, slots):
    """Add light times a weight to what the quotients f take, total (slots, 3)."""
    for c in range(slots.constants):
        value = weight * f[1 + c]
        for channel in range(3):
            total[c, channel] += value * texture[channel] * light[channel]
    if slots.curves > 0:
        j, here, there = weights_at(f[0], slots.bands, slots.tents)
        for c in range(slots.curves):
            slot, value = slots.constants + c * slots.bands + j, weight * f[1 + CONSTANTS + c]
            for channel in range(3):
                total[slot, channel] += value * here * light[channel]
            if there > 0.0:
                for channel in range(3):
                    total[slot + 1, channel] += value * there * light[channel]


@njit
def _to_steps(total, steps, unit):
    for n in range(total.shape[0]):
        most = np.float32(0)
        for slot in range(total.shape[1]):
            for channel in range(3):
                most = max(most, abs(total[n, slot, channel]))
        unit[n] = most / np.float32(STEPS)
        inverse = np.float32(STEPS) / most if most > 0.0 else np.float32(0)
        for slot in range(total.shape[1]):
            for channel in range(3):
                steps[n, channel, slot] = round(total[n, slot, channel] * inverse)


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _reflect(begin, end, surface, arriving, hand, out):
    surface, arriving = borrow(surface), borrow(arriving)
    lights = arriving.lights
    none = np.zeros((out.shape[1], 3), np.float32)
    for i in range(begin, end):
        parts = 4 if surface.edge[i] >= 0 else 1
        for part in range(parts):
            at, link = _part(surface, i, part)
            p, model = surface.row[at], surface.model[at]
            if model < 0 or surface.material[at] == hand:
                continue
            z, g = vec(surface.normal, at), vec(surface.geometric, at)
            s, t = tangents(z)
            wo = to_local(vec(surface.eye, at), s, t, z)
            pattern = pattern_of(link, arriving.width)
            for k in range(part, arriving.sample.shape[1], parts):
                wi = incident(arriving.patterns, pattern, k, wo)
                if wi[2] <= 0.0:
                    continue
                d = to_world(wi, s, t, z)
                if dot(d, g) <= 0.0:
                    continue
                came = _came(arriving, arriving.sample[link, k], d, none)
                weight = weight_of(arriving.patterns, wi, wo)
                f = evaluate(model, p, wi, wo)
                for n in range(out.shape[1]):
                    for channel in range(3):
                        out[i, n, channel] += weight * f[channel] * came[n, channel]
            for lamp in range(lights.kind.shape[0]):
                bits, count = arriving.seen[at, lamp], lights.points[lamp]
                for k in range(count):
                    if (bits >> np.uint64(k)) & np.uint64(1) == 0:
                        continue
                    w, light = _light(surface, lights, at, lamp, k)
                    wi = to_local(w, s, t, z)
                    if wi[2] <= 0.0:
                        continue
                    f = evaluate(model, p, wi, wo)
                    for channel in range(3):
                        out[i, 0, channel] += wi[2] / (count * parts) * f[channel] * light[channel]
