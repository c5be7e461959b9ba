"""The light that is folded, and the points that it falls on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light import table as lights
from engine.light.environment_samples import DEPTH
from engine.methods.brdf_editing.light_seen import Shining
from engine.methods.brdf_editing.links import BEYOND
from engine.methods.brdf_editing.patterns import Patterns, pattern_of
from engine.methods.brdf_editing.second import (
    FROZEN,
    HAND,
    MATT,
    Second,
    add_sent_in_hand,
    sent,
    sent_to_itself,
)
from engine.numerics.frames import tangents, to_world
from engine.numerics.octahedron import cell as cell_of
from engine.numerics.vec import dot, vec

illuminate = lights.illuminate


class Apart(NamedTuple):
    """What gloss sends to the matt part of n pixels that are not at edges, see `interleaved`.

    even    (n, deg + 1, 3) float32   over π the irradiance; n = 0 where nothing is kept apart
    behind  (n, deg + 1, slots, 3)    the same of coefficients in hand
    """

    even: NDArray[np.float32]
    behind: NDArray[np.float32]


class Arriving(NamedTuple):
    """The light that folds take.

    patterns, width   which rays a pixel has
    sample            (n, N) uint16 what they meet
    powers            (n_g, deg + 1, 3) float32
    second            what samples with gloss send
    apart             what they send along the even rays of pixels
    matt              (materials, 3) float32 albedo of what is matt of them, -1 where nothing is
    beyond            (4^DEPTH, 3) float32 radiance of the environment; (0, 3) for none
    lights            those that shine
    seen              (n + 4 m, l) uint64 which of their points are seen
    direct            (n + 4 m, 3) float32 irradiance over π that they give
    """

    patterns: Patterns
    width: int
    sample: NDArray[np.uint16]
    powers: NDArray[np.float32]
    second: Second
    apart: Apart
    matt: NDArray[np.float32]
    beyond: NDArray[np.float32]
    lights: Shining
    seen: NDArray[np.uint64]
    direct: NDArray[np.float32]


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


@njit
def part_of(surface, i, part):
    """(point, pixel whose rays it takes) of a part of pixel i."""
    e = surface.edge[i]
    if e < 0:
        return i, i
    return surface.edge.shape[0] + 4 * e + part, surface.donor[4 * e + part]


@njit
def is_apart(surface, arriving, i):
    """Whether what gloss sends to the matt part of pixel i is kept apart."""
    even = arriving.apart.even.shape[0] > 0 and surface.edge[i] < 0
    return even and arriving.matt[surface.material[i], 0] >= 0.0


@njit
def is_gloss(arriving, sample):
    """Whether what a ray meets sends other light in other directions."""
    return sample != BEYOND and arriving.second.kind[sample] != MATT


@njit
def came_along(arriving, sample, d, k, room):
    """Radiance along ray k of direction d, (deg + 1, 3), written into `room` where it is not kept.

    Of the cloud, or of the environment.
    """
    if sample == BEYOND:
        room[:] = 0.0
        if arriving.beyond.shape[0] > 0:
            room[0] = arriving.beyond[cell_of(d, DEPTH)]
        return room
    if arriving.second.kind[sample] == MATT:
        return arriving.powers[sample]
    if arriving.second.kind[sample] == FROZEN:
        sent(arriving.second, sample, d, k, room)
    else:
        sent_to_itself(arriving.second, sample, d, k, arriving.powers[sample], room)
    return room


@njit
def came_apart(arriving, sample, d, k, weight, room, behind):
    """The same for a pixel of a material that is not in hand.

    What coefficients in hand send goes to behind (deg + 1, slots, 3), times three weights, and only
    the rest is returned.
    """
    if behind.shape[1] == 0 or sample == BEYOND or arriving.second.kind[sample] != HAND:
        return came_along(arriving, sample, d, k, room)
    add_sent_in_hand(arriving.second, sample, d, k, weight, behind)
    room[:] = 0.0
    room[0] = arriving.second.glow[arriving.second.own[sample]]
    return room


@njit(fastmath={"contract", "reassoc"})
def gather_even(surface, arriving, i, part, colour, room, behind, total):
    """Fill total (deg + 1, 3) with the irradiance of a part of pixel i, over π.

    The rays that follow the cosine count alike, so that no direction need be known but of those
    that leave the scene, or meet gloss. colour and behind as in `came_apart`.
    """
    at, link = part_of(surface, i, part)
    parts, apart = (4 if surface.edge[i] >= 0 else 1), is_apart(surface, arriving, i)
    cosines, sample, powers = arriving.patterns.cosines, arriving.sample[link], arriving.powers
    share = np.float32(1.0 / cosines)
    weight = (share * colour[0], share * colour[1], share * colour[2])
    total[:] = 0.0
    z, g = vec(surface.normal, at), vec(surface.geometric, at)
    s, t = tangents(z)
    pattern = pattern_of(link, arriving.width)
    for k in range(part, cosines, parts):
        y = sample[k]
        if y != BEYOND and not is_gloss(arriving, y):
            came = powers[y]
        elif apart and is_gloss(arriving, y):
            continue
        else:
            d = to_world(vec(arriving.patterns.local[pattern], k), s, t, z)
            if dot(d, g) <= 0.0 or (y == BEYOND and arriving.beyond.shape[0] == 0):
                continue
            came = came_apart(arriving, y, d, k, weight, room, behind)
        for n in range(total.shape[0]):
            for c in range(3):
                total[n, c] += share * came[n, c]
    for c in range(3):
        total[0, c] += arriving.direct[at, c] / np.float32(parts)
    if apart:
        add_apart(arriving, i, (1.0, 1.0, 1.0), colour, total, behind)


@njit
def add_apart(arriving, i, colour, colour_behind, total, behind):
    """Add what gloss sends to the matt part of pixel i to both, each times a colour."""
    for n in range(total.shape[0]):
        for c in range(3):
            total[n, c] += colour[c] * arriving.apart.even[i, n, c]
            for slot in range(behind.shape[1]):
                behind[n, slot, c] += colour_behind[c] * arriving.apart.behind[i, n, slot, c]


@njit
def from_lamp(surface, light, at, lamp, k):
    """(direction, radiance times solid angle) of point k of a light, as seen from a surface."""
    wx, wy, wz, _, red, green, blue = illuminate(
        light.kind[lamp], light.row[lamp], light.texels, vec(surface.position, at),
        np.float64(surface.size[at]), light.place[lamp, k, 0], light.place[lamp, k, 1],
    )  # fmt: skip
    return (wx, wy, wz), (red, green, blue)
