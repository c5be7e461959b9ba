"""The light that is folded, and the points that it falls on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.light.environment_samples import DEPTH
from engine.methods.brdf_editing.light_seen import Shining
from engine.methods.brdf_editing.links import BEYOND
from engine.methods.brdf_editing.patterns import Patterns, pattern_of, rays_of
from engine.methods.brdf_editing.second import MATT, Second, bring_gloss
from engine.numerics.frames import tangents, to_local, to_world
from engine.numerics.octahedron import cell as cell_of
from engine.numerics.vec import vec

LANES = 4  # numbers that a processor adds at once, at least


class Even(NamedTuple):
    """What the rays of n pixels that follow the cosine bring, over π the irradiance.

    light   (n, deg + 1, 3) float32
    behind  (n, deg + 1, 3, slots) float32   of coefficients that the second bounce has in hand
    """

    light: NDArray[np.float32]
    behind: NDArray[np.float32]


class Arriving(NamedTuple):
    """The light that folds take.

    patterns, width   which rays a pixel has
    sample            (n, N) uint16 what they meet
    powers            (n_g, deg + 1, 3) float32
    rows              (n_g, lanes) float32, the same as `in_lanes` has it
    second            what samples with gloss send
    even              what matt surfaces receive, see `interleaved`
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
    rows: NDArray[np.float32]
    second: Second
    even: Even
    matt: NDArray[np.float32]
    beyond: NDArray[np.float32]
    lights: Shining
    seen: NDArray[np.uint64]
    direct: NDArray[np.float32]


class Surface(NamedTuple):
    """n pixels and the 4 m sub-samples of those at edges, one behind the other; see `FrameBuffer`.

    position, normal, geometric, size  as of `Points`, and eye, its view
    material, model, row  (n + 4 m,) as materials are now, row with their textures
    texture, gloss (n + 4 m, 3)  factors of the diffuse and specular reflectance
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
    gloss: NDArray[np.float32]
    edge: NDArray[np.int32]
    donor: NDArray[np.int32]


@njit
def part_of(surface, i, part):
    """(point, pixel whose rays it takes) of a part of pixel i."""
    e = surface.edge[i]
    if e < 0:
        return i, i
    return surface.edge.shape[0] + 4 * e + part, surface.donor[4 * e + part]


def in_lanes(powers: NDArray[np.float32]) -> NDArray[np.float32]:
    """(n_g, lanes): (n_g, deg + 1, 3) row by row, with zeros up to a multiple of LANES."""
    flat = powers.reshape(len(powers), -1)
    return np.pad(flat, ((0, 0), (0, -flat.shape[1] % LANES)))


@njit(inline="always")
def is_matt_light(kind, sample):
    """Whether a ray brings what its sample of the cloud sends all round, and so a row of powers."""
    return sample != BEYOND and kind[sample] == MATT


@njit
def fetch(rows, sample, part, parts, room):
    """Bring the rows (n_g, lanes) of what the rays of a part of a pixel meet, into room (N, lanes).

    All at once, as they lie anywhere in memory: one waits for them together, and not for each.
    """
    for q, k in enumerate(range(part, sample.shape[0], parts)):
        y = sample[k]
        if y != BEYOND:
            for lane in range(0, rows.shape[1], LANES):
                for column in range(lane, lane + LANES):
                    room[q, column] = rows[y, column]


@njit(inline="always")
def add_lanes(out, factor, came):
    """Add a row `came` times a factor."""
    times = np.float32(factor)
    for lane in range(0, came.shape[0], LANES):
        for q in range(lane, lane + LANES):
            out[q] += times * came[q]


@njit(inline="always")
def aim(surface, arriving, at, link, part, parts, rays):
    """Fill in the rays of a part of a pixel; returns how many, its frame and its local view."""
    z = vec(surface.normal, at)
    s, t = tangents(z)
    wo = to_local(vec(surface.eye, at), s, t, z)
    g = to_local(vec(surface.geometric, at), s, t, z)
    pattern = pattern_of(link, arriving.width)
    return rays_of(arriving.patterns, pattern, part, parts, wo, g, rays), (s, t, z), wo


@njit
def bring_rest(arriving, sample, rays, count, part, parts, frame, apart, room):
    """Fill rows (N, lanes) of rays that meet gloss, see `bring_gloss`, or leave the scene."""
    if arriving.second.base.shape[0] > 0:
        bring_gloss(
            arriving.second, arriving.powers, sample, rays, count, part, parts, frame, apart, room
        )
    lit = arriving.beyond.shape[0] > 0
    for q in range(count):
        if sample[part + q * parts] == BEYOND:
            room[q] = 0.0
            if lit and rays.z[q] > 0.0:
                d = to_world((rays.x[q], rays.y[q], rays.z[q]), frame[0], frame[1], frame[2])
                room[q, :3] = arriving.beyond[cell_of(d, DEPTH)]


@njit
def add_even(arriving, link, parts, colour, out):
    """Add what a surface of a matt colour, with the rays of a pixel, reflects of one part of them.

    out is (deg + 1, 3).
    """
    for c in range(3):
        share = np.float32(colour[c] / parts)
        for n in range(out.shape[0]):
            out[n, c] += share * arriving.even.light[link, n, c]
