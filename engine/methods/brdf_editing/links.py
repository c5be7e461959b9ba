"""What the rays of every view sample meet: the geometry of the first bounce from the eye.

A ray is stored as the gather sample that speaks for the place where it lands, in sixteen bits. That
is all that the tensor of `brdf_editing` (Ben-Artzi et al. 2008, eq. 20) is made from: which element
of the basis a ray counts for follows from its direction, and what comes along it is known once the
BRDFs of the other objects are.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.brdf_editing.patterns import Patterns, pattern_of, rays_of, room_for
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.gather_rays import find_samples, land
from engine.methods.fixed_view.hierarchy import level_start
from engine.methods.fixed_view.nearest import Grid
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_local, to_world
from engine.numerics.vec import add, scale, vec
from engine.scene.rays import RayTracer

CHUNK = 4096  # pixels
BATCH = 256  # pixels whose rays are cast at a time
BEYOND = 65535  # for a sample: the ray leaves the scene


@dataclass
class Job:
    """The links of all pixels' centres.

    positions, triangles   the scene's
    points                 the view samples, of a picture so wide
    leaf_position, leaf_geometric  (n_g, 3) of the gather samples, of a tree so deep
    """

    positions: NDArray[np.float32]
    triangles: NDArray[np.int32]
    points: Points
    width: int
    patterns: Patterns
    leaf_position: NDArray[np.float32]
    leaf_geometric: NDArray[np.float32]
    depth: int
    grid: Grid
    rays: RayTracer = field(repr=False)

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-len(self.points) // CHUNK)


def link_chunk(job: Job, chunk: int) -> dict[str, NDArray[Any]]:
    """`sample` (pixels, N) uint16 of one chunk."""
    first = chunk * CHUNK
    count = min(CHUNK, len(job.points) - first)
    n = job.patterns.local.shape[2]
    sample = np.full((count, n), BEYOND, np.uint16)
    for start in range(0, count, BATCH):
        stop = min(start + BATCH, count)
        sample[start:stop] = _met(job, first + start, first + stop)
    return {"sample": sample}


def _met(job: Job, start: int, stop: int) -> NDArray[np.uint16]:
    p, n = job.points, job.patterns.local.shape[2]
    room = (stop - start) * n
    origin, direction = np.zeros((2, room, 3), np.float32)
    ray = np.zeros(room, np.int32)
    count = _aim(
        start, stop, p.position, p.normal, p.geometric, p.view, p.model, job.patterns, job.width,
        job.rays.epsilon, origin, direction, ray,
    )  # fmt: skip
    origin, direction, ray = origin[:count], direction[:count], ray[:count]
    hits = job.rays.intersect(origin, direction)
    land(job.positions, job.triangles, hits.triangle, hits.distance, origin, direction)
    hit, cluster = hits.triangle >= 0, np.zeros(count, np.int32)
    apart = find_samples(
        job.rays, job.grid, job.depth, job.leaf_position, job.leaf_geometric, np.flatnonzero(hit),
        origin, direction, cluster,
    )  # fmt: skip
    met = np.where(hit, cluster - level_start.py_func(job.depth), -1).astype(np.int32)
    sample = np.full(room, BEYOND, np.uint16)
    _settle(ray, met, apart, n, sample)
    return sample.reshape(-1, n)


@njit(cache=True, nogil=True)
def _aim(
    start, stop, position, normal, geometric, view, model, patterns, width, epsilon, origin,
    direction, ray,
):  # fmt: skip
    """Fill in the rays that leave their surface, and which they are of all; returns how many."""
    patterns = borrow(patterns)
    count, n = 0, patterns.local.shape[2]
    rays = room_for(n)
    for i in range(start, stop):
        if model[i] < 0:
            continue
        z, g = vec(normal, i), vec(geometric, i)
        s, t = tangents(z)
        wo = to_local(vec(view, i), s, t, z)
        x, pattern = add(vec(position, i), scale(g, epsilon)), pattern_of(i, width)
        rays_of(patterns, pattern, 0, 1, wo, to_local(g, s, t, z), rays)
        for k in range(n):
            if rays.z[k] <= 0.0:
                continue
            d = to_world((rays.x[k], rays.y[k], rays.z[k]), s, t, z)
            for c in range(3):
                origin[count, c], direction[count, c] = x[c], d[c]
            ray[count] = (i - start) * n + k
            count += 1
    return count


@njit(cache=True, nogil=True)
def _settle(ray, met, apart, n, sample):
    """Write down what rays met; one that no sample is in sight of meets what the last one did."""
    last, pixel = -1, -1
    for r in range(ray.shape[0]):
        if ray[r] // n != pixel:
            last, pixel = -1, ray[r] // n
        if met[r] < 0:
            continue
        if not apart[r] or last < 0:
            last = met[r]
        sample[ray[r]] = min(last, BEYOND - 1)
