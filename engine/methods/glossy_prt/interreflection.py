"""Bounced transport vectors: `glossy_prt` §3.2, §4.2 (Wang, Tran, Luebke 2006).

One pass gathers, for every vertex x, the vectors of the surfaces around it (eq. 8):

    T_k^{i+1}(x) = ∫ Σ_λ h_λ(x~, -ω) T_λ^i(x~) g_k(ω) (1 - V(x, ω)) (n·ω) dω

over the texels of a coarse cube map, with x~ what the ray along ω meets. The paper snaps it to a
vertex; here it lies between the three of its triangle. What the rays of one vertex have to do with
each vertex around is summed up first, so that every vector is read once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.glossy_prt.direct import light_vector
from engine.methods.glossy_prt.terms import Terms
from engine.methods.glossy_prt.vertices import Vertices, frame
from engine.methods.glossy_prt.views import Maps, view_vectors
from engine.numerics import cube_map
from engine.numerics.borrow import borrow
from engine.numerics.frames import to_local
from engine.numerics.vec import dot, scale, vec
from engine.numerics.wavelet_vectors import (
    WaveletVectors,
    before,
    keep_largest,
    room_for,
    white_light,
)
from engine.scene import surface
from engine.scene.scene import Scene


class Sources(NamedTuple):
    """The vectors of all materials behind each other.

    start, place                of all vertices, as in `WaveletVectors`
    base, scale, steps          of all vertices, flat
    base_at, scale_at, step_at  (v,) int64   where those of a vertex begin
    channels                    (materials,) int32   1 or 3
    """

    start: NDArray[np.int64]
    place: NDArray[np.uint16]
    base: NDArray[np.float32]
    scale: NDArray[np.float32]
    steps: NDArray[np.int8]
    base_at: NDArray[np.int64]
    scale_at: NDArray[np.int64]
    step_at: NDArray[np.int64]
    channels: NDArray[np.int32]


@dataclass(frozen=True)
class Job:
    """One pass for the clusters of one material; `channels` of the vectors that it makes.

    bounds (clusters + 1,) tells where the vertices of each begin.
    """

    scene: Scene
    vertices: Vertices
    bounds: NDArray[np.int32]
    terms: Terms
    maps: Maps
    sources: Sources
    gather_texels: int
    light_texels: int
    coefficients: int
    tolerance: float
    channels: int


def stack(vectors: Sequence[WaveletVectors], terms: Sequence[Terms]) -> Sources:
    """The vectors of the materials, of the materials' terms each."""
    width = np.concatenate([np.full(len(v.length), v.scale.shape[1]) for v in vectors])
    length = np.concatenate([v.length for v in vectors])

    return Sources(
        start=np.concatenate([[0], np.cumsum(length, dtype=np.int64)]),
        place=np.concatenate([v.place for v in vectors]),
        base=np.concatenate([v.base.ravel() for v in vectors]),
        scale=np.concatenate([v.scale.ravel() for v in vectors]),
        steps=np.concatenate([v.steps.ravel() for v in vectors]),
        base_at=before(cube_map.FACES * width),
        scale_at=before(width),
        step_at=before(width * length),
        channels=np.array(
            [v.scale.shape[1] // t.count for v, t in zip(vectors, terms, strict=True)], np.int32
        ),
    )


def bounce_chunk(job: Job, chunk: int) -> dict[str, NDArray[Any]]:
    """The vectors of a cluster, as the arrays of `WaveletVectors`."""
    first = int(job.bounds[chunk])
    s = slice(first, int(job.bounds[chunk + 1]))
    v, rays = job.vertices, job.scene.rays
    directions = cube_map.directions(job.gather_texels)
    areas = cube_map.vector_areas(job.gather_texels)
    above = v.normal[s].astype(np.float64) @ areas.T > 0
    vertex, cell = np.nonzero(above)
    hits = rays.intersect(v.eye[s][vertex], directions.astype(np.float32)[cell])
    most, n = job.coefficients, job.light_texels
    count = len(above)
    room = room_for(count, most, job.terms.count * job.channels)
    weight = job.terms.weight_of(job.channels)
    _gather(
        first, np.searchsorted(vertex, np.arange(count + 1)), cell, hits.triangle, hits.b1, hits.b2,
        directions, areas, job.scene.geometry, job.scene.material_table, v, job.maps, job.sources,
        job.terms.flat, job.terms.light.shape[0], job.terms.count, job.terms.channels,
        job.channels, white_light(n), weight, most, job.tolerance, *room,
    )  # fmt: skip
    return room.packed()._asdict()


@njit(cache=True, nogil=True)
def _gather(
    first, ray, cell, triangle, b1, b2, directions, areas, geometry, materials, vertices, maps,
    sources, light, size, terms, light_channels, channels, white, weight, most, tolerance,
    length, base, scale_, place, steps,
):  # fmt: skip
    geometry, materials, maps = borrow(geometry), borrow(materials), borrow(maps)
    vertices, sources = borrow(vertices), borrow(sources)
    wide = 0
    for m in range(maps.terms.shape[0]):
        wide = max(wide, maps.terms[m])
    row, h = np.zeros(materials.row.shape[1], np.float32), np.zeros((3, 3 * wide), np.float32)
    g = np.zeros(light.shape[1], np.float32)
    slot = np.full(vertices.position.shape[0], -1, np.int32)
    values = np.zeros((len(white), channels * terms), np.float32)
    for i in range(length.shape[0]):
        here = range(ray[i], ray[i + 1])
        s, t, n = frame(vertices.normal, vertices.tangent, first + i)
        whole = 0.0
        for j in range(areas.shape[0]):
            whole += max(0.0, dot(n, vec(areas, j)))
        if whole == 0.0:
            continue
        # factor[q, λ, c K + k]: what term λ of source q has to do with the vector's channels.
        source = np.zeros(min(3 * len(here), slot.shape[0]), np.int32)
        factor = np.zeros((len(source), wide, channels * terms), np.float32)
        count = 0
        for r in here:
            w = vec(directions, cell[r])
            back = scale(w, -1.0)
            if triangle[r] < 0 or not surface.shows_front(geometry, triangle[r], back):
                continue
            rows = view_vectors(
                geometry, materials, vertices, maps, triangle[r], b1[r], b2[r], back, row, h
            )
            seen = maps.terms[geometry.material[triangle[r]]]
            weights = (1.0 - b1[r] - b2[r], np.float64(b1[r]), np.float64(b2[r]))
            light_vector(light, size, to_local(w, s, t, n), 1.0, g)
            unit = np.pi / whole * dot(n, vec(areas, cell[r]))
            for corner in range(3):
                v = vertices.corners[triangle[r], corner]
                if slot[v] < 0:
                    slot[v] = count
                    source[count] = v
                    count += 1
                f = factor[slot[v]]
                mine = h[corner if rows == 3 else 0]
                for k in range(seen):
                    for c in range(channels):
                        shine = np.float32(unit * weights[corner] * mine[3 * k + c])
                        own = c * terms if light_channels == 3 else 0
                        for q in range(terms):
                            f[k, c * terms + q] += shine * g[own + q]
        values[:] = 0.0
        for q in range(count):
            v = source[q]
            slot[v] = -1
            m = vertices.material[v]
            _add(sources, v, maps.terms[m], sources.channels[m], factor[q], terms, values)
        length[i] = keep_largest(
            values, white, weight, most, tolerance, base[i], scale_[i], place[i], steps[i]
        )


@njit(nogil=True, fastmath={"contract", "reassoc"})
def _add(sources, v, source_terms, source_channels, factor, terms, values):
    """Add the vector of vertex v, each of its terms times its factors, to values (texels, c)."""
    wide, width = values.shape[1], source_terms * source_channels
    size, first = values.shape[0] // cube_map.FACES, sources.step_at[v]
    base, scale_at = sources.base_at[v], sources.scale_at[v]
    for c in range(source_channels):
        # A grey term goes into all channels, a coloured one into that of its own.
        low, high = (0, wide) if source_channels == 1 else (c * terms, (c + 1) * terms)
        for k in range(0, source_terms, 2):
            # Two terms at a time, as the numbers they are added to are many and far apart.
            own, two = c * source_terms + k, k + 1 < source_terms
            f, g = factor[k, low:high], factor[k + two, low:high]
            f_unit = sources.scale[scale_at + own]
            g_unit = sources.scale[scale_at + own + two] * np.float32(two)
            at = first + own
            for p in range(sources.start[v], sources.start[v + 1]):
                x = f_unit * np.float32(sources.steps[at])
                y = g_unit * np.float32(sources.steps[at + two])
                at += width
                into = values[sources.place[p], low:high]
                for q in range(f.shape[0]):
                    into[q] += f[q] * x + g[q] * y
            for face in range(cube_map.FACES):
                x = sources.base[base + face * width + own]
                y = sources.base[base + face * width + own + two] * np.float32(two)
                into = values[face * size, low:high]
                for q in range(f.shape[0]):
                    into[q] += f[q] * x + g[q] * y
