"""A gather matrix row by row: the long part of every fixed-view precompute.

Work is cut into chunks of tiles. A chunk is a function of a `Job` and its number alone, so that
any executor can run it, lose it and run it again.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import DIFFUSE, ROW
from engine.brdf.diffuse import Diffuse
from engine.brdf.table import INDEX
from engine.methods.fixed_view.gather_rays import aim, land, settle
from engine.methods.fixed_view.hierarchy import Clusters
from engine.methods.fixed_view.links import closure, find_links, hide, room_for_links
from engine.methods.fixed_view.nearest import Grid, build_grid
from engine.methods.fixed_view.packing import pack
from engine.methods.fixed_view.rows import STEPS, TILE, PackedRows, make_scratch, project
from engine.scene.rays import RayTracer

CHUNK_TILES = 64
HEMISPHERE = 64  # rays that measure how closed a point's surroundings are
SURE = 0.03  # standard error of such a measure, at most
LONGEST = 8  # a tile's list is at most so many times the coefficients asked for


class Lobes(NamedTuple):
    """What the points of a job do with light: one part of a BRDF each.

    view   (n, 3) float32   unit, towards the eye
    model  (n,) int32       BRDF model
    row    (n, 16) float32  its parameters
    """

    view: NDArray[np.float32]
    model: NDArray[np.int32]
    row: NDArray[np.float32]


def cosine_lobes(normal: NDArray[np.float32]) -> Lobes:
    """Of matt points with normals (n, 3)."""
    row = np.zeros((len(normal), ROW), np.float32)
    row[:, DIFFUSE : DIFFUSE + 3] = 1
    return Lobes(normal, np.full(len(normal), INDEX[Diffuse], np.int32), row)


@dataclass
class Job:
    """The rows of the points in `tiles`, gathered from the leaves of `clusters`.

    positions, triangles          the scene's geometry, for the shadow rays
    tiles      (m, 64) int32      indices of points, -1 for none
    position, normal, geometric   (n, 3) float32, the points
    leaf_position, leaf_geometric (n_g, 3) float32, the gather samples
    importance (n_g,) float32     see `rows.pack`
    lobes                         of the points
    count                         rays of a point, see `gather_rays`; 0 for links in their place
    link_size, patch_size         see `links`, which know no lobe but the cosine
    coefficients                  that a row would keep with a list of its own
    """

    positions: NDArray[np.float32]
    triangles: NDArray[np.int32]
    tiles: NDArray[np.int32]
    position: NDArray[np.float32]
    normal: NDArray[np.float32]
    geometric: NDArray[np.float32]
    leaf_position: NDArray[np.float32]
    leaf_geometric: NDArray[np.float32]
    clusters: Clusters
    importance: NDArray[np.float32]
    lobes: Lobes
    count: int
    link_size: float
    patch_size: float
    coefficients: int
    seed: int
    rays: RayTracer | None = field(default=None, repr=False)
    grid: Grid | None = field(default=None, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "rays": None, "grid": None}

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-len(self.tiles) // CHUNK_TILES)


def gather_chunk(job: Job, chunk: int) -> dict[str, NDArray[Any]]:
    """Rows of one chunk as the arrays of PackedRows, and how much of their energy was kept.

    Also counts rays. Deterministic whatever runs beside it.
    """
    tiles = job.tiles[chunk * CHUNK_TILES : (chunk + 1) * CHUNK_TILES]
    gather = _Rays(job) if job.count else _Links(job)
    lists: list[PackedRows] = []
    kept = np.ones(len(tiles), np.float32)
    rays = np.zeros(len(tiles), np.int64)
    ids, values = np.zeros(1 << 19, np.int32), np.zeros(1 << 19, np.float32)
    starts = np.zeros(TILE + 1, np.int64)
    scratch = make_scratch(len(job.leaf_position))
    most = LONGEST * job.coefficients
    wavelets = np.zeros(most, np.int32)
    mean, scale = np.zeros((2, most), np.float32)
    steps = np.zeros(most * TILE, np.int8)
    for t, index in enumerate(tiles):
        first, cluster, weight, rays[t] = gather(index)
        while True:
            count = project(
                first, cluster, weight, job.clusters.depth, scratch, ids, values, starts
            )
            if count >= 0:
                break
            ids, values = np.zeros(2 * len(ids), np.int32), np.zeros(2 * len(ids), np.float32)
        length = np.zeros((1, len(STEPS)), np.int32)
        count, size, kept[t] = pack(
            ids, values, starts, index >= 0, job.importance, job.coefficients, scratch, length[0],
            wavelets, mean, scale, steps,
        )  # fmt: skip
        lists.append(
            PackedRows(
                length,
                wavelets[:count].copy(),
                mean[:count].copy(),
                scale[:count].copy(),
                steps[:size].copy(),
            )
        )
    joined = PackedRows(*(np.concatenate(parts) for parts in zip(*lists, strict=True)))
    return {**joined._asdict(), "kept": kept, "rays": rays}


Rows = tuple[NDArray[np.int32], NDArray[np.int32], NDArray[np.float32], int]
"""first (b + 1,), cluster, weight (p,) as `rows.project` wants them, and the rays they took."""


class _Rays:
    """Rows of a tile by rays, with room for them."""

    def __init__(self, job: Job) -> None:
        most = TILE * job.count
        self._job, self._tracer = job, _tracer(job)
        self._origin, self._direction = np.zeros((2, most, 3), np.float32)
        self._weight, self._cluster = np.zeros(most, np.float32), np.zeros(most, np.int32)
        self._first = np.zeros(TILE + 1, np.int32)

    def __call__(self, index: NDArray[np.int32]) -> Rows:
        n = self._aim(index)
        job, origin, direction = self._job, self._origin[:n], self._direction[:n]
        hits = self._tracer.intersect(origin, direction)
        land(
            _grid(job), job.clusters.depth, job.positions, job.triangles, job.leaf_position,
            job.leaf_geometric, hits.triangle, hits.distance, origin, direction, self._cluster,
        )  # fmt: skip
        apart = self._tracer.occluded(origin, direction, 1.0)
        settle(self._first, hits.triangle, apart, self._weight)
        return self._first, self._cluster, self._weight, n

    def closed(self, index: NDArray[np.int32]) -> NDArray[np.float64]:
        """(b,) share of each point's lobe that something is in."""
        n = self._aim(index)
        hit = self._tracer.occluded(self._origin[:n], self._direction[:n])
        sums = np.concatenate([[0.0], np.cumsum(self._weight[:n] * hit, dtype=np.float64)])
        return (sums[self._first[1:]] - sums[self._first[:-1]]) / math.pi

    def _aim(self, index: NDArray[np.int32]) -> int:
        job = self._job
        rays: int = aim(
            index, job.position, job.normal, job.geometric, *job.lobes, self._tracer.epsilon,
            job.seed, job.count, self._origin, self._direction, self._first, self._weight,
        )  # fmt: skip
        return rays


class _Links:
    """Rows of a tile by links, with room for them."""

    def __init__(self, job: Job) -> None:
        self._job, self._tracer = job, _tracer(job)
        self._room = room_for_links(TILE, 1 << 16, 1 << 18)
        self._hemisphere = _Rays(replace(job, count=HEMISPHERE))

    def __call__(self, index: NDArray[np.int32]) -> Rows:
        job, n = self._job, self._find(index)
        room = self._room
        blocked = self._tracer.occluded(room.origin[:n], room.direction[:n], 1.0)
        hide(room.first, room.link, room.weight, blocked)
        closed = self._hemisphere.closed(index)
        closure(room.first, room.cluster, room.weight, job.clusters.depth, closed, SURE)
        return room.first, room.cluster, room.weight, n

    def _find(self, index: NDArray[np.int32]) -> int:
        job = self._job
        while True:
            links: int = find_links(
                index,
                job.position,
                job.normal,
                job.geometric,
                job.leaf_position,
                job.leaf_geometric,
                job.clusters,
                job.link_size,
                job.patch_size,
                self._tracer.epsilon,
                job.seed,
                self._room,
            )
            if links >= 0:
                return links
            self._room = room_for_links(TILE, 2 * len(self._room.origin), 2 * len(self._room.link))


def _tracer(job: Job) -> RayTracer:
    if job.rays is None:
        job.rays = RayTracer(job.positions, job.triangles)
    return job.rays


def _grid(job: Job) -> Grid:
    if job.grid is None:
        job.grid = build_grid(job.leaf_position, job.leaf_geometric, job.clusters.area)
    return job.grid
