"""Final gather by rays: a point shoots them and takes the light of the samples where they land.

The other way besides `links`. Directions follow what the point does with light: the cosine, or the
glossy lobe of its BRDF. A ray that lands gives its weight to the nearest gather sample in sight, so
an entry of the row is the share of the lobe in which the sample is seen:

    F_xj = π / N · Σ_k f cos θ / (p a)  over the rays k of N that land nearest to j

with f, p the BRDF of one part alone and the density of its sampler, and a its albedo, so that
a F / π takes radiance to reflected radiance for matt and glossy parts alike. There is no 1/r² that
would have to be clamped in corners, and what rays do not see does not count. The price is noise,
which falls faster than 1/√N because the directions are those of a lattice.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table as brdfs
from engine.brdf.base import luminance
from engine.methods.fixed_view.hierarchy import level_start
from engine.methods.fixed_view.nearest import Grid, nearest_beyond
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_local, to_world
from engine.numerics.octahedron import cell as cell_of
from engine.numerics.sampling import uniform
from engine.numerics.vec import add, cross, dot, normalize, scale, sub, vec
from engine.scene.rays import RayTracer

evaluate, sample_direction, density = brdfs.evaluate, brdfs.sample, brdfs.pdf
GOLDEN = 0.6180339887498949
LIFT = 0.1  # spacings of samples above the surface, for looking along it
# Samples around the place where a ray lands of which the first in its sight speaks for it. With one
# try, 4 % of the rays in a furnished room find a wall or a chair leg in between, most of them in
# dark places; what the others have in their stead makes such a room 4 % too bright.
TRIES = 8
SHIFTS = 1 << 20  # dimensions of `uniform` from here on turn the lattice of each point


@njit(cache=True, nogil=True)
def aim(
    index, position, normal, geometric, view, model, row, epsilon, seed, count, origin, direction,
    first, weight, norm,
):  # fmt: skip
    """Up to `count` rays from each of the points `index` (b,); -1 is no point.

    position, normal, geometric, view (n, 3), model (n,), row (n, ROW) as in `Points`, but with one
    part of the BRDF alone. Fills origin, direction (b * count, 3) and weight (b * count,); row b
    owns first[b] to first[b + 1]. norm (b,) gets π / (a N). Returns the number of rays. The weights
    of a row sum to π, less those of rays that a shading normal sends under the surface.
    """
    rows = borrow(row)
    rays = 0
    for b in range(index.shape[0]):
        first[b] = rays
        i = index[b]
        if i < 0:
            continue
        n, s, t, wo = shading_frame(normal, view, i)
        g, p = vec(geometric, i), rows[i]
        start = add(vec(position, i), scale(g, epsilon))
        shift1, shift2 = uniform(seed, i, SHIFTS), uniform(seed, i, SHIFTS + 1)
        total = 0.0
        for k in range(count):
            # A rank-one lattice, shifted for each point.
            u = ((k + shift1) / count, (k * GOLDEN + shift2) % 1.0, 0.5)
            wi = sample_direction(model[i], p, wo, u)
            pdf = density(model[i], p, wi, wo)
            if wi[2] <= 0.0 or pdf <= 0.0:
                continue
            f = evaluate(model[i], p, wi, wo)
            w = luminance(f) * wi[2] / pdf
            total += w
            d = to_world(wi, s, t, n)
            if dot(d, g) <= 0.0 or w <= 0.0:
                continue
            for c in range(3):
                origin[rays, c] = start[c]
                direction[rays, c] = d[c]
            weight[rays] = w
            rays += 1
        norm[b] = math.pi / total if total > 0.0 else 0.0
        for r in range(first[b], rays):
            weight[r] *= norm[b]
    first[index.shape[0]] = rays
    return rays


@njit
def shading_frame(normal, view, i):
    """(normal, tangent, bitangent) of point i, and the way to the eye in that frame."""
    n = vec(normal, i)
    s, t = tangents(n)
    return n, s, t, to_local(vec(view, i), s, t, n)


@njit(cache=True, nogil=True)
def escape(free, direction, weight, depth, cell, escaped):
    """Give the weight of rays that hit nothing to the environment samples of their directions.

    free (r,) bool; fills cell (r,), clusters of the tree over 4^depth samples, and escaped (r,),
    weights that are 0 for rays that hit something.
    """
    for r in range(free.shape[0]):
        cell[r], escaped[r] = 0, 0.0
        if free[r]:
            cell[r] = level_start(depth) + cell_of(vec(direction, r), depth)
            escaped[r] = weight[r]


@njit(cache=True, nogil=True)
def land(positions, triangles, triangle, distance, origin, direction):
    """Put the place where rays hit `triangle` (r,) at `distance` into origin (r, 3), in place.

    Their direction becomes the normal there, on the side that was met.
    """
    for r in range(triangle.shape[0]):
        t, d = triangle[r], vec(direction, r)
        if t < 0:
            continue
        a = vec(positions, triangles[t, 0])
        g = normalize(
            cross(sub(vec(positions, triangles[t, 1]), a), sub(vec(positions, triangles[t, 2]), a))
        )
        if dot(g, d) > 0.0:
            g = scale(g, -1.0)
        x = add(vec(origin, r), scale(d, np.float64(distance[r])))
        for c in range(3):
            origin[r, c], direction[r, c] = x[c], g[c]


def find_samples(
    tracer: RayTracer,
    grid: Grid,
    depth: int,
    leaf_position: NDArray[np.float32],
    leaf_geometric: NDArray[np.float32],
    which: NDArray[np.intp],
    place: NDArray[np.float32],
    normal: NDArray[np.float32],
    cluster: NDArray[np.int32],
) -> NDArray[np.bool_]:
    """(n,) bool: of the rays `which` landed, those that no sample nearby is in sight of.

    place, normal (n, 3) are what `land` found; fills cluster (n,) with the others' leaf clusters.
    """
    beyond = np.full(len(place), -1, np.float32)
    for _ in range(TRIES):
        start, way = np.zeros((2, len(which), 3), np.float32)
        _next_sample(
            grid, depth, leaf_position, leaf_geometric, which, place, normal, beyond, cluster,
            start, way,
        )  # fmt: skip
        which = which[tracer.occluded(start, way, 1.0)]
    apart = np.zeros(len(place), np.bool_)
    apart[which] = True
    return apart


@njit(cache=True, nogil=True)
def _next_sample(
    grid, depth, leaf_position, leaf_normal, which, place, normal, beyond, cluster, start, way
):  # fmt: skip
    """The leaf clusters (r,) of the samples nearest to where the rays `which` (w,) have landed.

    beyond (r,) float32 is how far away the last ones were that were tried, -1 at first. Fills
    start and way (w, 3), from there to the sample, above both surfaces.
    """
    grid = borrow(grid)
    for k in range(which.shape[0]):
        r = which[k]
        x, g = vec(place, r), vec(normal, r)
        j, found = nearest_beyond(grid, x, g, beyond[r])
        for c in range(3):
            way[k, c] = 0.0
        if j < 0:
            continue
        cluster[r], beyond[r] = level_start(depth) + j, found
        lift = LIFT * grid.spacing[j]
        above = add(x, scale(g, lift))
        end = add(vec(leaf_position, j), scale(vec(leaf_normal, j), lift))
        to = sub(end, above)
        for c in range(3):
            start[k, c], way[k, c] = above[c], to[c]


@njit(cache=True, nogil=True)
def settle(first, triangle, apart, weight):
    """Take the weight from rays that hit nothing, or that are `apart` (r,) from all samples.

    What a row loses to the latter, which landed in cracks, its other hits share.
    """
    for b in range(first.shape[0] - 1):
        landed = kept = 0.0
        for r in range(first[b], first[b + 1]):
            if triangle[r] >= 0:
                landed += weight[r]
            if triangle[r] < 0 or apart[r]:
                weight[r] = 0.0
            kept += weight[r]
        for r in range(first[b], first[b + 1]):
            weight[r] *= landed / kept if kept > 0.0 else 0.0
