"""Direct transport vectors: `glossy_prt` §3.1, §4.1 (Wang, Tran, Luebke 2006).

Of vertex x and term k (eq. 3), over the texels ω of a cube map,

    T_k(x, ω) = g_k(ω) V(x, ω) n·ω

with the visible part of the texel V and the exact mean of the cosine over it. The cosines of an
open vertex are made to integrate to π, so that white light gives what it ought to.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.glossy_prt.terms import Terms
from engine.methods.glossy_prt.vertices import Vertices, frame
from engine.methods.glossy_prt.visibility import TOGETHER, OpenParts
from engine.numerics import cube_map
from engine.numerics.cluster_basis import cluster
from engine.numerics.frames import to_local
from engine.numerics.hemisphere_maps import disk_taps
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, vec
from engine.numerics.wavelet_vectors import (
    keep_largest,
    room_for,
    shortened,
    to_haar,
    white_light,
)

SOURCE = "source_"  # before the names of the arrays of vectors that bounces are gathered from
MOST = 1024  # wavelets of a vector that a cluster is made of


@dataclass(frozen=True)
class Job:
    """Direct transport of the clusters of one material.

    open_parts     (eye, normal) tells how much of each texel is open, as that of `visibility`
    bounds         (clusters + 1,) where the vertices of each begin
    cluster_error  of the clusters, see `cluster_basis`; 0 for none
    sources        whether vectors of `coefficients` are wanted too where there are clusters
    """

    open_parts: OpenParts
    vertices: Vertices
    bounds: NDArray[np.int32]
    terms: Terms
    light_texels: int
    visibility_texels: int
    coefficients: int
    tolerance: float
    cluster_error: float
    sources: bool


def direct_chunk(job: Job, chunk: int) -> dict[str, NDArray[Any]]:
    """Transport of a cluster, as the arrays of `Clusters` or `WaveletVectors` or both of them."""
    s = slice(job.bounds[chunk], job.bounds[chunk + 1])
    v, n = job.vertices, job.light_texels
    pieces = [slice(k, min(k + TOGETHER, s.stop)) for k in range(s.start, s.stop, TOGETHER)]
    opened = np.concatenate(
        [
            np.zeros((0, cube_map.FACES * n * n), np.uint8),
            *(job.open_parts(v.eye[piece], v.normal[piece]) for piece in pieces),
        ]
    )
    light, weight = job.terms.flat, job.terms.weight_of(job.terms.channels)
    white, most = white_light(n), MOST if job.cluster_error else job.coefficients
    room = room_for(len(opened), most, light.shape[1])
    for_ranges(
        _project, len(opened), v.normal[s], v.tangent[s], opened, (job.visibility_texels // n) ** 2,
        cube_map.directions(n), _mean_directions(n), cube_map.solid_angles(n), light,
        job.terms.light.shape[0], white, weight, most, job.tolerance, *room, grain=16,
    )  # fmt: skip
    vectors = room.packed()
    if not job.cluster_error:
        return vectors._asdict()
    made = cluster(vectors, white, weight, job.cluster_error)._asdict()
    if job.sources:
        short = shortened(vectors, weight, job.coefficients, job.tolerance, n)
        made |= {f"{SOURCE}{name}": array for name, array in short._asdict().items()}
    return made


@cache
def _mean_directions(n: int) -> NDArray[np.float64]:
    """(6 n², 3): times a normal, the mean cosine over each texel."""
    return cube_map.vector_areas(n) / cube_map.solid_angles(n)[:, None]


@njit(cache=True, nogil=True)
def _project(
    begin, end, normal, tangent, opened, parts, directions, means, solid, light, size, white,
    weight, most, tolerance, length, base, scale, place, steps,
):  # fmt: skip
    values = np.zeros((opened.shape[1], light.shape[1]), np.float32)
    for i in range(begin, end):
        values[:] = 0.0
        _sample(normal, tangent, i, opened, parts, directions, means, solid, light, size, values)
        to_haar(values)
        length[i] = keep_largest(
            values, white, weight, most, tolerance, base[i], scale[i], place[i], steps[i]
        )


@njit(nogil=True)
def _sample(normal, tangent, i, opened, parts, directions, means, solid, light, size, values):
    """Fill values (6 n², c) with the transport of vertex i; channels as in `Terms.flat`."""
    s, t, n = frame(normal, tangent, i)
    whole = 0.0
    for j in range(opened.shape[1]):
        whole += max(0.0, dot(n, vec(means, j))) * solid[j]
    if whole == 0.0:  # no normal
        return
    unit = np.pi / (whole * parts)
    for j in range(opened.shape[1]):
        if opened[i, j] == 0:
            continue
        cosine = dot(n, vec(means, j))
        if cosine <= 0.0:
            continue
        weight = unit * opened[i, j] * cosine
        light_vector(light, size, to_local(vec(directions, j), s, t, n), weight, values[j])


@njit(nogil=True)
def light_vector(light, size, w, weight, out):
    """Fill out (channels · K,) with g_k(w) times a weight; channels as in `Terms.flat`."""
    taps, (fx, fy) = disk_taps(w, size)
    a, b = weight * (1.0 - fx) * (1.0 - fy), weight * fx * (1.0 - fy)
    c, d = weight * (1.0 - fx) * fy, weight * fx * fy
    for q in range(out.shape[0]):
        out[q] = (
            a * light[taps[0], q]
            + b * light[taps[1], q]
            + c * light[taps[2], q]
            + d * light[taps[3], q]
        )
