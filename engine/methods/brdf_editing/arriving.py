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
from engine.numerics.frames import tangents, to_world
from engine.numerics.octahedron import cell as cell_of
from engine.numerics.vec import dot, vec

illuminate = lights.illuminate


class Arriving(NamedTuple):
    """The light that folds take.

    patterns, width   which rays a pixel has
    sample            (n, N) uint16 what they meet
    powers            (n_g, deg + 1, 3) float32
    beyond            (4^DEPTH, 3) float32 radiance of the environment; (0, 3) for none
    lights            those that shine
    seen              (n + 4 m, l) uint64 which of their points are seen
    direct            (n + 4 m, 3) float32 irradiance over π that they give
    """

    patterns: Patterns
    width: int
    sample: NDArray[np.uint16]
    powers: NDArray[np.float32]
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


@njit(inline="always")
def came_along(powers, beyond, sample, d, none):
    """Radiance along a ray, (deg + 1, 3): of the cloud, or of the environment."""
    if sample != BEYOND:
        return powers[sample]
    none[0] = 0.0
    if beyond.shape[0] > 0:
        none[0] = beyond[cell_of(d, DEPTH)]
    return none


@njit(fastmath={"contract", "reassoc"})
def gather_even(surface, arriving, at, link, part, parts, none, total):
    """Fill total (deg + 1, 3) with the irradiance of a part, over π times the number of parts.

    The rays that follow the cosine count alike, so that no direction need be known but of those
    that leave the scene.
    """
    cosines, sample, powers = arriving.patterns.cosines, arriving.sample[link], arriving.powers
    share = np.float32(1.0 / cosines)
    total[:] = 0.0
    z, g = vec(surface.normal, at), vec(surface.geometric, at)
    s, t = tangents(z)
    for k in range(part, cosines, parts):
        if sample[k] == BEYOND:
            if arriving.beyond.shape[0] == 0:
                continue
            w = vec(arriving.patterns.local[pattern_of(link, arriving.width)], k)
            d = to_world(w, s, t, z)
            if dot(d, g) <= 0.0:
                continue
            none[0] = arriving.beyond[cell_of(d, DEPTH)]
            came = none
        else:
            came = powers[sample[k]]
        for n in range(total.shape[0]):
            for c in range(3):
                total[n, c] += share * came[n, c]
    for c in range(3):
        total[0, c] += arriving.direct[at, c] / np.float32(parts)


@njit
def from_lamp(surface, light, at, lamp, k):
    """(direction, radiance times solid angle) of point k of a light, as seen from a surface."""
    wx, wy, wz, _, red, green, blue = illuminate(
        light.kind[lamp], light.row[lamp], light.texels, vec(surface.position, at),
        np.float64(surface.size[at]), light.place[lamp, k, 0], light.place[lamp, k, 1],
    )  # fmt: skip
    return (wx, wy, wz), (red, green, blue)
