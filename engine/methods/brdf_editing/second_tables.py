"""What gather samples with gloss send in each direction: made when a material is taken in hand.

`brdf_editing` (Ben-Artzi et al. 2008), §4.3. Gather samples have rays too (`links`), the same ones
in every local frame. What arrives along a ray is taken as even within the cell around it, so that
what an element of a lobe sends on is a matrix product (`engine.brdf.lobe_weights`).
"""

from __future__ import annotations

from functools import cache
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.base import DIFFUSE, SPECULAR, without_grain
from engine.brdf.curve_basis import coefficients
from engine.brdf.equivalent_albedo import shares
from engine.brdf.layers import LAYERS
from engine.brdf.lobe_weights import lobe_weights
from engine.light.environment_samples import DEPTH
from engine.methods.brdf_editing.light_seen import Shining
from engine.methods.brdf_editing.links import BEYOND
from engine.methods.brdf_editing.patterns import SIDE, Patterns, patterns
from engine.methods.brdf_editing.polynomial import Later, Light
from engine.methods.brdf_editing.second import FROZEN, HAND, VIEWS, Second
from engine.methods.brdf_editing.settings import Settings
from engine.methods.fixed_view.cloud import GatherCloud
from engine.numerics.frames import tangents, to_world
from engine.numerics.hemisphere_maps import texels
from engine.numerics.octahedron import cell as cell_of
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec
from engine.scene.scene import MaterialTable

RAYS = 256  # of a gather sample
FINE = 64  # elements that the lobes of frozen materials are resolved with
BLOCK = 512  # gather samples whose tables are made at a time
LEAST = 1e-3  # albedo of which the inverse is taken
COARSER = 2  # levels between the environment's samples and the cells around rays


class SecondRays(NamedTuple):
    """What a precompute finds of it: `sample` (n_g, RAYS) uint16, `seen` (n_g, l) uint64."""

    sample: NDArray[np.uint16]
    seen: NDArray[np.uint64]


class Incoming(NamedTuple):
    """What arrives at gather samples.

    later    light on the cloud
    matt     (n_g, 3)        albedo of the constants alone, textures applied
    texture  (n_g, 3)        factor of the diffuse reflectance
    albedo   (3,)            that in hand
    beyond   (4^DEPTH, 3)    radiance of the environment; (0, 3) for none
    """

    later: Later
    matt: Light
    texture: Light
    albedo: NDArray[np.float64]
    beyond: Light


@cache
def second_patterns() -> Patterns:
    """The rays of gather samples: one lattice of cosines for all."""
    found = patterns(Settings(view_rays=RAYS, lobe_rays=0.0))
    return found._replace(local=np.repeat(found.local[:1], SIDE * SIDE, axis=0))


def second_lattice() -> NDArray[np.float64]:
    """(RAYS, 3): their directions."""
    return np.ascontiguousarray(second_patterns().local[0].T)


def no_second(cloud: GatherCloud, light: Shining) -> Second:
    """All samples are matt."""
    points, n = cloud.points, len(cloud)

    def none(axes: int) -> Light:
        return np.zeros((0,) * axes, np.float32)

    return Second(
        kind=np.zeros(n, np.uint8), place=np.zeros(n, np.int32),
        own=np.zeros(n, np.int32),
        cell=np.zeros((VIEWS, VIEWS), np.int32), base=none(3), frozen=none(4),
        glow=none(2), constant=none(3), hand=none(5), share=np.zeros(0),
        inverse=np.zeros(3, np.float32), bands=1,
        tents=False, position=points.position, normal=points.normal, material=points.material,
        size=points.size, model=np.zeros(0, np.int32), row=none(2),
        seen=np.zeros((0, 0), np.uint64), lights=light,
    )  # fmt: skip


def second_bounce(
    cloud: GatherCloud,
    rays: SecondRays,
    table: MaterialTable,
    hand: int,
    came: Incoming,
    light: Shining,
    settings: Settings,
) -> Second:
    """The tables while the material `hand` is edited; -1 for none."""
    second = no_second(cloud, light)
    grid, lattice = texels(VIEWS), second_lattice()
    of, irradiance = cloud.points.material, came.later.irradiance
    base = [second.base.reshape(0, *irradiance.shape[1:])]
    frozen = [np.zeros((0, len(grid.number), *irradiance.shape[1:]), np.float32)]
    beyond = _coarser(came.beyond)
    for m, model in enumerate(table.model):
        layers, p = LAYERS[model], without_grain(table.row[m][None])[0]
        mine = np.flatnonzero(of == m)
        if layers is None or layers.curves == 0 or len(mine) == 0:
            continue
        if m == hand:
            elements, basis = settings.second_bands, settings.basis
            weights = lobe_weights(int(model), p, elements, basis, grid.direction, lattice)
            sent = _sent(cloud, rays, came, beyond, mine, weights.reshape(-1, RAYS)[None])
            second.kind[mine], second.own[mine] = HAND, np.arange(len(mine))
            second = second._replace(
                hand=sent.reshape(len(mine), len(grid.number), -1, *irradiance.shape[1:]),
                share=shares(int(model), p, settings.bands, basis).constants,
                inverse=_inverse(came.albedo),
                bands=elements, tents=basis == "tents", glow=cloud.emission[mine],
                constant=came.texture[mine, None] * irradiance[mine],
            )  # fmt: skip
        elif not (p[SPECULAR : SPECULAR + 3] > 0).any():
            continue
        else:
            second.kind[mine] = FROZEN
        weights = lobe_weights(int(model), p, FINE, "tents", grid.direction, lattice)
        lobes = coefficients(layers, p, FINE, "tents")[1].astype(np.float32)
        whole = np.einsum("vljk,ljc->cvk", weights, lobes, optimize=True)
        second.place[mine] = sum(map(len, base)) + np.arange(len(mine))
        frozen.append(_sent(cloud, rays, came, beyond, mine, whole))
        base.append(came.matt[mine, None] * irradiance[mine])
        base[-1][:, 0] += cloud.emission[mine]
    cell = np.zeros(VIEWS * VIEWS, np.int32)
    cell[grid.number] = np.arange(len(grid.number))
    row = without_grain(table.row)
    row[:, DIFFUSE : DIFFUSE + 3] = 0
    return second._replace(
        cell=cell.reshape(VIEWS, VIEWS), base=np.concatenate(base), frozen=np.concatenate(frozen),
        model=table.model.astype(np.int32), row=row, seen=rays.seen,
    )  # fmt: skip


def _inverse(albedo: NDArray[np.float64]) -> Light:
    known = albedo > LEAST
    return np.where(known, 1 / np.where(known, albedo, 1), 0).astype(np.float32)


def _coarser(beyond: Light) -> Light:
    """The environment on cells about as large as those of rays."""
    return beyond.reshape(-1, 4**COARSER, 3).mean(axis=1, dtype=np.float64).astype(np.float32)


def _sent(
    cloud: GatherCloud,
    rays: SecondRays,
    came: Incoming,
    beyond: Light,
    mine: NDArray[np.intp],
    weights: Light,
) -> Light:
    """(m, v, deg + 1, 3): what samples send on, by weights (3, v, RAYS), or (1, v, RAYS)."""
    incoming = came.later.incoming
    degrees = incoming.shape[1]
    out = np.zeros((len(mine), weights.shape[1], degrees, 3), np.float32)
    for start in range(0, len(mine), BLOCK):
        part, sent = mine[start : start + BLOCK], out[start : start + BLOCK]
        light = np.zeros((len(part), RAYS, degrees, 3), np.float32)
        for_ranges(
            _arriving, len(part), part, rays.sample, incoming, beyond, cloud.points.normal,
            second_lattice(), light, grain=16,
        )  # fmt: skip
        if len(weights) == 1:
            sent[:] = (weights[0] @ light.reshape(len(part), RAYS, -1)).reshape(sent.shape)
        else:
            for c in range(3):
                sent[..., c] = weights[c] @ light[..., c]
    return out


@njit(cache=True, nogil=True)
def _arriving(start, stop, mine, sample, incoming, beyond, normal, lattice, out):
    for i in range(start, stop):
        y = mine[i]
        z = vec(normal, y)
        s, t = tangents(z)
        for k in range(lattice.shape[0]):
            if sample[y, k] != BEYOND:
                out[i, k] = incoming[sample[y, k]]
            elif beyond.shape[0] > 0:
                d = to_world(vec(lattice, k), s, t, z)
                for c in range(3):
                    out[i, k, 0, c] = beyond[cell_of(d, DEPTH - COARSER), c]
