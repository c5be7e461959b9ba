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
    points, n, number = cloud.points, len(cloud), texels(VIEWS).number
    cell = np.zeros(VIEWS * VIEWS, np.int32)
    cell[number] = np.arange(len(number))

    def none(axes: int) -> Light:
        return np.zeros((0,) * axes, np.float32)

    return Second(
        kind=np.zeros(n, np.uint8), place=np.zeros(n, np.int32),
        own=np.zeros(n, np.int32),
        cell=cell.reshape(VIEWS, VIEWS), entry=np.zeros((0, 0), np.int32), base=none(3),
        frozen=none(3), glow=none(2), constant=none(3), hand=none(4), share=np.zeros(0),
        inverse=np.zeros(3, np.float32), bands=1,
        tents=False, position=points.position, normal=points.normal, material=points.material,
        size=points.size, cut=0, model=np.zeros(0, np.int32), row=none(2),
        seen=np.zeros((0, 0), np.uint64), lights=light,
    )  # fmt: skip


def second_bounce(
    cloud: GatherCloud,
    rays: SecondRays,
    asked: NDArray[np.bool_],
    table: MaterialTable,
    hand: int,
    cut: int,
    came: Incoming,
    light: Shining,
    settings: Settings,
) -> Second:
    """The tables while the material `hand`, cut as one of LAYERS, is edited; -1 for none.

    asked (n_g, views) bool tells which views of samples are looked up, see `second_views`.
    """
    second = no_second(cloud, light)
    grid, lattice = texels(VIEWS), second_lattice()
    of, irradiance = cloud.points.material, came.later.irradiance
    base = [second.base.reshape(0, *irradiance.shape[1:])]
    frozen = [np.zeros((0, *irradiance.shape[1:], 1), np.float32)]
    beyond, found = _coarser(came.beyond), asked.any(axis=1)
    entry = np.zeros(asked.shape, np.int32)
    # That in hand comes first, so that its rows of both tables have the same numbers.
    for m in sorted(range(len(table.model)), key=lambda m: m != hand):
        model, p = table.model[m], without_grain(table.row[m][None])[0]
        layers, mine = LAYERS[model], np.flatnonzero((of == m) & found)
        if layers is None or layers.curves == 0 or len(mine) == 0:
            continue
        pairs = asked[mine]
        arriving = came.later.incoming, beyond, mine, pairs, rays.sample, cloud.points.normal
        if m == hand:
            elements, basis = settings.second_bands, settings.basis
            weights = lobe_weights(cut, p, elements, basis, grid.direction, lattice)
            weights = weights.reshape(len(grid.number), 1, -1, RAYS)
            second.kind[mine], second.own[mine] = HAND, np.arange(len(mine))
            second = second._replace(
                hand=_sent(*arriving, weights), cut=cut,
                share=shares(cut, p, settings.bands, basis).constants,
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
        whole = np.einsum("vljk,ljc->vck", weights, lobes, optimize=True)[:, :, None]
        entry[mine] = (np.cumsum(pairs) - 1).reshape(pairs.shape) + sum(map(len, frozen))
        second.place[mine] = sum(map(len, base)) + np.arange(len(mine))
        frozen.append(_sent(*arriving, np.ascontiguousarray(whole)))
        base.append(came.matt[mine, None] * irradiance[mine])
        base[-1][:, 0] += cloud.emission[mine]
    row = without_grain(table.row)
    row[:, DIFFUSE : DIFFUSE + 3] = 0
    return second._replace(
        entry=entry, base=np.concatenate(base), frozen=np.concatenate(frozen)[..., 0],
        model=table.model.astype(np.int32), row=row, seen=rays.seen,
    )  # fmt: skip


def _inverse(albedo: NDArray[np.float64]) -> Light:
    known = albedo > LEAST
    return np.where(known, 1 / np.where(known, albedo, 1), 0).astype(np.float32)


def _coarser(beyond: Light) -> Light:
    """The environment on cells about as large as those of rays."""
    return beyond.reshape(-1, 4**COARSER, 3).mean(axis=1, dtype=np.float64).astype(np.float32)


def _sent(
    incoming: Light,
    beyond: Light,
    mine: NDArray[np.intp],
    pairs: NDArray[np.bool_],
    sample: NDArray[np.uint16],
    normal: Light,
    weights: Light,
) -> Light:
    """(pairs, deg + 1, 3, slots): what samples `mine` send to the views that are asked of each.

    pairs (m, v); weights (v, channels, slots, RAYS), with one channel for all three or three.
    """
    count = pairs.sum(axis=1)
    out = np.zeros((int(count.sum()), *incoming.shape[1:], weights.shape[2]), np.float32)
    for_ranges(
        _send, len(mine), mine, np.cumsum(count) - count, pairs, sample, incoming, beyond, normal,
        second_lattice(), weights, out, grain=64,
    )  # fmt: skip
    return out


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc"})
def _send(
    start, stop, mine, first, pairs, sample, incoming, beyond, normal, lattice, weights, out
):  # fmt: skip
    light = np.zeros((*incoming.shape[1:], lattice.shape[0]), np.float32)
    for i in range(start, stop):
        _arriving(mine[i], sample, incoming, beyond, vec(normal, mine[i]), lattice, light)
        row = first[i]
        for v in range(pairs.shape[1]):
            if not pairs[i, v]:
                continue
            for n in range(out.shape[1]):
                for c in range(3):
                    for slot in range(out.shape[3]):
                        weight = weights[v, min(c, weights.shape[1] - 1), slot]
                        total = np.float32(0)
                        for k in range(lattice.shape[0]):
                            total += weight[k] * light[n, c, k]
                        out[row, n, c, slot] = total
            row += 1


@njit
def _arriving(y, sample, incoming, beyond, normal, lattice, out):
    """Fill out (deg + 1, 3, RAYS) with the light that arrives at sample y along its rays."""
    out[:] = 0.0
    s, t = tangents(normal)
    for k in range(lattice.shape[0]):
        if sample[y, k] != BEYOND:
            for n in range(out.shape[0]):
                for c in range(3):
                    out[n, c, k] = incoming[sample[y, k], n, c]
        elif beyond.shape[0] > 0:
            d = to_world(vec(lattice, k), s, t, normal)
            for c in range(3):
                out[0, c, k] = beyond[cell_of(d, DEPTH - COARSER), c]
