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
from engine.light.environment_samples import DEPTH
from engine.methods.fixed_view.gather_rays import aim, escape, find_samples, land, settle
from engine.methods.fixed_view.hierarchy import Clusters, level_start
from engine.methods.fixed_view.importance import environment_importance
from engine.methods.fixed_view.links import closure, find_links, hide, room_for_links
from engine.methods.fixed_view.nearest import Grid, build_grid
from engine.methods.fixed_view.openings import aim_through, open_cells, share
from engine.methods.fixed_view.packing import Packer
from engine.methods.fixed_view.ray_noise import STRATIFIED
from engine.methods.fixed_view.rows import Rows
from engine.numerics.packed import TILE
from engine.scene.rays import RayTracer

CHUNK_TILES = 64
ENVIRONMENT = "environment_"
HEMISPHERE = 64  # rays that measure how closed a point's surroundings are
SURE = 0.03  # standard error of such a measure, at most


class Lobes(NamedTuple):
    """What the points of a job do with light: one part of a BRDF each.

    view   (n, 3) float32   unit, towards the eye
    model  (n,) int32       BRDF model
    row    (n, ROW) float32  its parameters
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
    environment_coefficients      the same of environment samples
    opening_rays                  rays of a point to what it sees of the environment, at most, see
                                  `openings`; 0 for none but those above
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
    environment_coefficients: int
    seed: int
    opening_rays: int = 0
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

    The arrays of the rows of environment samples have `ENVIRONMENT` before their names. Also counts
    rays. Deterministic whatever runs beside it.
    """
    tiles = job.tiles[chunk * CHUNK_TILES : (chunk + 1) * CHUNK_TILES]
    gather = _Rays(job) if job.count else _Links(job)
    surfaces = Packer(job.importance, job.coefficients)
    beyond = Packer(environment_importance(), job.environment_coefficients, STRATIFIED)
    kept = np.ones(len(tiles), np.float32)
    rays = np.zeros(len(tiles), np.int64)
    for t, index in enumerate(tiles):
        landed, escaped, rays[t] = gather(index)
        kept[t] = surfaces.add(landed, index >= 0)
        beyond.add(escaped, index >= 0)
    environment = {ENVIRONMENT + k: a for k, a in beyond.packed()._asdict().items()}
    return {**surfaces.packed()._asdict(), **environment, "kept": kept, "rays": rays}


class _Rays:
    """Rows of a tile by rays, with room for them."""

    def __init__(self, job: Job) -> None:
        most = TILE * job.count
        self._job, self._tracer = job, _tracer(job)
        self._origin, self._direction = np.zeros((2, most, 3), np.float32)
        self._weight, self._escaped = np.zeros((2, most), np.float32)
        self._cluster, self._cell = np.zeros((2, most), np.int32)
        self._first, self._norm = np.zeros(TILE + 1, np.int32), np.zeros(TILE)
        self._openings = _Openings(job, self._tracer) if job.opening_rays else None

    def __call__(self, index: NDArray[np.int32]) -> tuple[Rows, Rows, int]:
        """Rows of surfaces, rows of environment samples, and the rays that they took."""
        n = self._aim(index)
        job, origin, direction = self._job, self._origin[:n], self._direction[:n]
        hits = self._tracer.intersect(origin, direction)
        escaped, more = self._escape(index, hits.triangle < 0)
        land(job.positions, job.triangles, hits.triangle, hits.distance, origin, direction)
        apart = find_samples(
            self._tracer, _grid(job), job.clusters.depth, job.leaf_position, job.leaf_geometric,
            np.flatnonzero(hits.triangle >= 0), origin, direction, self._cluster,
        )  # fmt: skip
        settle(self._first, hits.triangle, apart, self._weight)
        return Rows(self._first, self._cluster, self._weight), escaped, n + more

    def look(self, index: NDArray[np.int32]) -> tuple[NDArray[np.float64], Rows, int]:
        """(b,) share of each point's lobe that something is in, and what environment is in it."""
        n = self._aim(index)
        free = ~self._tracer.occluded(self._origin[:n], self._direction[:n])
        upto = np.concatenate([[0.0], np.cumsum(self._weight[:n] * ~free, dtype=np.float64)])
        return np.diff(upto[self._first]) / math.pi, *self._escape(index, free)

    def _escape(self, index: NDArray[np.int32], free: NDArray[np.bool_]) -> tuple[Rows, int]:
        escape(free, self._direction, self._weight, DEPTH, self._cell, self._escaped)
        rows = Rows(self._first, self._cell, self._escaped)
        if self._openings is None or free.all() or not free.any():
            return rows, 0
        return self._openings(index, rows, self._norm, free, self._direction)

    def _aim(self, index: NDArray[np.int32]) -> int:
        job = self._job
        rays: int = aim(
            index, job.position, job.normal, job.geometric, *job.lobes, self._tracer.epsilon,
            job.seed, job.count, self._origin, self._direction, self._first, self._weight,
            self._norm,
        )  # fmt: skip
        return rays


class _Openings:
    """More rays through openings, with room for them."""

    def __init__(self, job: Job, tracer: RayTracer) -> None:
        most = TILE * job.opening_rays
        self._job, self._tracer = job, tracer
        self._origin, self._direction = np.zeros((2, most, 3), np.float32)
        self._weight, self._cluster = np.zeros(most, np.float32), np.zeros(most, np.int32)
        self._first = np.zeros(TILE + 1, np.int32)

    def __call__(
        self,
        index: NDArray[np.int32],
        rows: Rows,
        norm: NDArray[np.float64],
        free: NDArray[np.bool_],
        direction: NDArray[np.float32],
    ) -> tuple[Rows, int]:
        """The rows of rays of which some are free, made finer, and the rays that it took."""
        job = self._job
        is_open = open_cells(free, direction)
        cells = np.flatnonzero(is_open).astype(np.int32)
        k = math.isqrt(job.opening_rays // len(cells))
        if k == 0:
            return rows, 0
        n = aim_through(
            index, job.position, job.normal, job.geometric, *job.lobes, job.count, norm, cells, k,
            DEPTH, self._tracer.epsilon, job.seed, self._origin, self._direction, self._first,
            self._cluster, self._weight,
        )  # fmt: skip
        self._weight[:n] *= ~self._tracer.occluded(self._origin[:n], self._direction[:n])
        share(
            index, job.normal, *job.lobes, job.count, is_open, k, rows.first, direction, free,
            rows.weight,
        )  # fmt: skip
        return both(rows, Rows(self._first, self._cluster, self._weight)), n


def both(a: Rows, b: Rows) -> Rows:
    """Rows that have the entries of two."""
    length = np.diff(a.first), np.diff(b.first)
    first = np.concatenate([[0], np.cumsum(length[0] + length[1])]).astype(np.int32)
    order = np.argsort(
        np.concatenate([np.repeat(np.arange(len(n)), n) for n in length]), kind="stable"
    )
    cluster, weight = (
        np.concatenate([x[: a.first[-1]], y[: b.first[-1]]])[order]
        for x, y in zip(a[1:], b[1:], strict=True)
    )
    return Rows(first, cluster, weight)


class _Links:
    """Rows of a tile by links, with room for them."""

    def __init__(self, job: Job) -> None:
        self._job, self._tracer = job, _tracer(job)
        self._room = room_for_links(TILE, 1 << 16, 1 << 18)
        self._hemisphere = _Rays(replace(job, count=HEMISPHERE))

    def __call__(self, index: NDArray[np.int32]) -> tuple[Rows, Rows, int]:
        """As of `_Rays`."""
        job, n = self._job, self._find(index)
        room = self._room
        blocked = self._tracer.occluded(room.origin[:n], room.direction[:n], 1.0)
        hide(room.first, room.link, room.weight, blocked)
        closed, escaped, more = self._hemisphere.look(index)
        closure(room.first, room.cluster, room.weight, job.clusters.depth, closed, SURE)
        return Rows(room.first, room.cluster, room.weight), escaped, n + more

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
        area = job.clusters.area[level_start.py_func(job.clusters.depth) :]
        job.grid = build_grid(job.leaf_position, job.leaf_geometric, area)
    return job.grid
