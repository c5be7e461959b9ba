"""The bounce behind the first as gloss: what a gather sample sends depends on the direction.

`brdf_editing` (Ben-Artzi et al. 2008), §4.3: caustics, and mirrors that show a glossy thing, need a
series such as (64, 16) or (128, 8, 1), in which the second bounce from the eye has some elements of
its own. `second_tables` makes what is looked up here; lamps are followed one by one.

Of frozen materials the tables hold what they send. Of the one in hand they hold what each element
sends, for pixels of other materials. Where it sees itself, its second lobe keeps the shape that it
had when it was taken in hand, and follows its albedo.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdfs
from engine.brdf.curve_basis import weights_at
from engine.brdf.layers import CONSTANTS, factors
from engine.methods.brdf_editing.light_seen import Shining, from_lamp
from engine.methods.brdf_editing.links import BEYOND
from engine.methods.brdf_editing.patterns import GOLDEN, PLASTIC
from engine.numerics.frames import tangents, to_local, to_world
from engine.numerics.vec import scale, vec

evaluate = brdfs.evaluate

MATT, FROZEN, HAND = 0, 1, 2
VIEWS = 10  # across the disk of directions that tables are made for
LAMP_POINTS = 2  # of each lamp, for each ray that lands
LEAST = 0.05  # cosine of a ray that the normal of its sample has near or below the surface


class Second(NamedTuple):
    """What samples of the gather cloud send.

    kind      (n_g,) uint8      MATT: the same all round
    place     (n_g,) int32      in `base`
    own       (n_g,) int32      in `glow` and `constant`
    cell      (VIEWS, VIEWS) int32   which view
    entry     (n_g, views) int32     in `frozen` and `hand`, for what is looked up
    base      (m, deg + 1, 3)   what a sample sends all round; of the one in hand as it was taken
    frozen    (pairs, deg + 1, 3)   its gloss, by the direction
    glow      (h, 3)            emission of samples of the material in hand
    constant  (h, deg + 1, 3)   what a white matt one in its place would send
    hand      (pairs, deg + 1, 3, curves · bands)   its gloss, by direction and element
    share     (constants,)      albedos of the constants
    inverse   (3,)              1 / albedo in hand, as it was taken; 0 where there was none
    bands, tents                elements of a curve in hand, and which they are
    position, normal, material, size   of gather samples
    cut                         of the material in hand, one of LAYERS
    model, row                  of materials, row without the matt part
    seen, lights                which points of the lights samples see
    """

    kind: NDArray[np.uint8]
    place: NDArray[np.int32]
    own: NDArray[np.int32]
    cell: NDArray[np.int32]
    entry: NDArray[np.int32]
    base: NDArray[np.float32]
    frozen: NDArray[np.float32]
    glow: NDArray[np.float32]
    constant: NDArray[np.float32]
    hand: NDArray[np.float32]
    share: NDArray[np.float64]
    inverse: NDArray[np.float32]
    bands: int
    tents: bool
    position: NDArray[np.float32]
    normal: NDArray[np.float32]
    material: NDArray[np.int32]
    size: NDArray[np.float32]
    cut: int
    model: NDArray[np.int32]
    row: NDArray[np.float32]
    seen: NDArray[np.uint64]
    lights: Shining

    @property
    def slots(self) -> int:
        """Number of coefficients that the second bounce has of the material in hand."""
        return len(self.share) + self.hand.shape[3]


@njit(forceinline=True)
def _towards(second, y, d):
    """(local direction back along a ray d, frame) of sample y."""
    z = vec(second.normal, y)
    s, t = tangents(z)
    w = to_local(scale(d, -1.0), s, t, z)
    return (w[0], w[1], max(LEAST, w[2])), (s, t, z)


@njit(forceinline=True)
def _view_of(second, wo, k):
    """One of the four views around wo, taken by turns over the rays, as often as it is near."""
    x = 0.5 * (wo[0] + 1.0) * VIEWS - 0.5 + (k * PLASTIC[0]) % 1.0
    y = 0.5 * (wo[1] + 1.0) * VIEWS - 0.5 + (k * PLASTIC[1]) % 1.0
    i = min(VIEWS - 1, max(0, math.floor(x)))
    j = min(VIEWS - 1, max(0, math.floor(y)))
    return second.cell[j, i]


@njit
def view_along(second, y, d, k):
    """The view of sample y that is looked up for ray k, of direction d."""
    return _view_of(second, _towards(second, y, d)[0], k)


@njit(forceinline=True)
def _lamp_point(second, y, lamp, k, turn, frame):
    """(seen, local direction, radiance times solid angle) of one of LAMP_POINTS of a lamp."""
    light = second.lights
    count = light.points[lamp]
    q = int(count * ((turn + 0.5) / LAMP_POINTS + k * GOLDEN)) % count
    if (second.seen[y, lamp] >> np.uint64(q)) & np.uint64(1) == 0:
        return False, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)
    w, radiance = from_lamp(second, light, y, lamp, q)
    wi = to_local(w, frame[0], frame[1], frame[2])
    return wi[2] > 0.0, wi, scale(radiance, 1.0 / LAMP_POINTS)


@njit(forceinline=True)
def _sent(second, y, d, k, out):
    """Fill a row of light with what sample y sends back along ray k, of direction d."""
    wo, frame = _towards(second, y, d)
    place = second.place[y]
    gloss, base = second.frozen[second.entry[y, _view_of(second, wo, k)]], second.base[place]
    for n in range(base.shape[0]):
        for c in range(3):
            out[3 * n + c] = base[n, c] + gloss[n, c]
    m = second.material[y]
    for lamp in range(second.seen.shape[1]):
        if second.seen[y, lamp] == np.uint64(0):
            continue
        for turn in range(LAMP_POINTS):
            seen, wi, light = _lamp_point(second, y, lamp, k, turn, frame)
            if seen:
                f = evaluate(second.model[m], second.row[m], wi, wo)
                for c in range(3):
                    out[c] += wi[2] * f[c] * light[c]


@njit(forceinline=True)
def _in_proportion(second, y, matt, out):
    """What a sample of the material in hand sends to that itself, made of what `_sent` found.

    As it was taken, in proportion to its albedo. matt (deg + 1, 3) is what it sends as a matt one,
    for channels in which it was black.
    """
    glow = second.glow[second.own[y]]
    for c in range(3):
        if second.inverse[c] > 0.0:
            out[c] -= glow[c]
            for n in range(matt.shape[0] - 1, 0, -1):
                out[3 * n + c] = out[3 * n - 3 + c] * second.inverse[c]
            out[c] = glow[c]
        else:
            for n in range(matt.shape[0]):
                out[3 * n + c] = matt[n, c]


@njit(fastmath={"contract", "reassoc"})
def bring_gloss(second, powers, sample, rays, count, part, parts, frame, apart, room):
    """Fill rows (N, lanes) of rays that meet gloss: all that it sends.

    With `apart` only the glow of the material in hand; the rest is for `add_behind`.
    """
    for q in range(count):
        k = part + q * parts
        y = sample[k]
        if rays.z[q] <= 0.0 or y == BEYOND or second.kind[y] == MATT:
            continue
        out = room[q]
        if apart and second.kind[y] == HAND:
            out[:] = 0.0
            out[:3] = second.glow[second.own[y]]
            continue
        d = to_world((rays.x[q], rays.y[q], rays.z[q]), frame[0], frame[1], frame[2])
        _sent(second, y, d, k, out)
        if second.kind[y] == HAND:
            _in_proportion(second, y, powers[y], out)


@njit(fastmath={"contract", "reassoc"})
def add_behind(second, sample, rays, count, part, parts, frame, weight, total):
    """Add what each coefficient of samples in hand sends back along rays, times weight (3, N).

    total is (deg + 1, 3, slots).
    """
    for q in range(count):
        k = part + q * parts
        y = sample[k]
        if rays.z[q] > 0.0 and y != BEYOND and second.kind[y] == HAND:
            d = to_world((rays.x[q], rays.y[q], rays.z[q]), frame[0], frame[1], frame[2])
            _add_sent(second, y, d, k, (weight[0, q], weight[1, q], weight[2, q]), total)


@njit(forceinline=True)
def _add_sent(second, y, d, k, weight, total):
    wo, frame = _towards(second, y, d)
    own, constants = second.own[y], second.share.shape[0]
    gloss, matt = second.hand[second.entry[y, _view_of(second, wo, k)]], second.constant[own]
    for n in range(total.shape[0]):
        for c in range(3):
            share = np.float32(weight[c])
            for q in range(constants):
                total[n, c, q] += share * second.share[q] * matt[n, c]
            for slot in range(gloss.shape[2]):
                total[n, c, constants + slot] += share * gloss[n, c, slot]
    m, curves = second.material[y], gloss.shape[2] // second.bands
    for lamp in range(second.seen.shape[1]):
        if second.seen[y, lamp] == np.uint64(0):
            continue
        for turn in range(LAMP_POINTS):
            seen, wi, light = _lamp_point(second, y, lamp, k, turn, frame)
            if not seen:
                continue
            f = factors(second.cut, second.row[m], wi, wo)
            j, here, there = weights_at(f[0], second.bands, second.tents)
            for q in range(curves):
                slot, value = constants + q * second.bands + j, wi[2] * f[1 + CONSTANTS + q]
                for c in range(3):
                    total[0, c, slot] += weight[c] * value * here * light[c]
                    if there > 0.0:
                        total[0, c, slot + 1] += weight[c] * value * there * light[c]
