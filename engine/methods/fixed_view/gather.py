"""A gather matrix row by row: the long part of every fixed-view precompute.

Work is cut into chunks of tiles. A chunk is a function of a `Job` and its number alone, so that
any executor can run it, lose it and run it again.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.methods.fixed_view.hierarchy import Clusters
from engine.methods.fixed_view.links import (
    Links,
    closure,
    find_links,
    hemisphere_rays,
    room_for_links,
)
from engine.methods.fixed_view.rows import TILE, PackedRows, make_scratch, pack, project
from engine.scene.rays import RayTracer

CHUNK_TILES = 64
HEMISPHERE = 64  # rays that measure how closed a point's surroundings are
SURE = 0.03  # standard error of such a measure, at most
LONGEST = 8  # a tile's list is at most so many times the coefficients asked for


@dataclass
class Job:
    """The rows of the points in `tiles`, gathered from the leaves of `clusters`.

    positions, triangles          the scene's geometry, for the shadow rays
    tiles      (m, 64) int32      indices of points, -1 for none
    position, normal, geometric   (n, 3) float32, the points
    leaf_position, leaf_geometric (n_g, 3) float32, the gather samples
    importance (n_g,) float32     see `rows.pack`
    link_size, patch_size         see `links`
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
    link_size: float
    patch_size: float
    coefficients: int
    seed: int
    rays: RayTracer | None = field(default=None, repr=False)

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "rays": None}

    @property
    def chunks(self) -> int:
        """Number of chunks."""
        return -(-len(self.tiles) // CHUNK_TILES)


def gather_chunk(job: Job, chunk: int) -> dict[str, NDArray[Any]]:
    """Rows of one chunk as the arrays of PackedRows, and how much of their energy was kept.

    Also counts rays. Deterministic whatever runs beside it.
    """
    if job.rays is None:
        job.rays = RayTracer(job.positions, job.triangles)
    tiles = job.tiles[chunk * CHUNK_TILES : (chunk + 1) * CHUNK_TILES]
    lists: list[PackedRows] = []
    kept = np.ones(len(tiles), np.float32)
    rays = np.zeros(len(tiles), np.int64)
    room = room_for_links(TILE, 1 << 16, 1 << 18)
    ids, values = np.zeros(1 << 19, np.int32), np.zeros(1 << 19, np.float32)
    starts = np.zeros(TILE + 1, np.int64)
    origin = np.zeros((TILE * HEMISPHERE, 3), np.float32)
    direction = np.ones((TILE * HEMISPHERE, 3), np.float32)
    scratch = make_scratch(len(job.leaf_position))
    for t, index in enumerate(tiles):
        room, links = _links_of(job, index, room)
        rays[t] = links
        blocked = job.rays.occluded(room.origin[:links], room.direction[:links], 1.0)
        hemisphere_rays(
            index, job.position, job.normal, job.geometric, job.rays.epsilon, job.seed, HEMISPHERE,
            origin, direction,
        )  # fmt: skip
        closed = job.rays.occluded(origin, direction).reshape(TILE, HEMISPHERE).mean(axis=1)
        closure(
            room.first, room.link, room.cluster, room.weight, blocked, job.clusters.depth, closed,
            SURE,
        )  # fmt: skip
        while True:
            count = project(
                room.first, room.link, room.cluster, room.weight, blocked, job.clusters.depth,
                scratch, ids, values, starts,
            )  # fmt: skip
            if count >= 0:
                break
            ids, values = np.zeros(2 * len(ids), np.int32), np.zeros(2 * len(ids), np.float32)
        most = LONGEST * job.coefficients
        wavelets, scale = np.zeros(most, np.int32), np.zeros(most, np.float32)
        steps = np.zeros((most, TILE), np.int8)
        length, kept[t] = pack(
            ids, values, starts, job.importance, job.coefficients, scratch, wavelets, scale, steps
        )
        lists.append(
            PackedRows(
                np.array([length], np.int32), wavelets[:length], scale[:length], steps[:length]
            )
        )
    joined = PackedRows(*(np.concatenate(parts) for parts in zip(*lists, strict=True)))
    return {**joined._asdict(), "kept": kept, "rays": rays}


def _links_of(job: Job, index: NDArray[np.int32], room: Links) -> tuple[Links, int]:
    while True:
        links = find_links(
            index, job.position, job.normal, job.geometric, job.leaf_position, job.leaf_geometric,
            job.clusters, job.link_size, job.patch_size, job.rays.epsilon,  # type: ignore[union-attr]
            job.seed, room,
        )  # fmt: skip
        if links >= 0:
            return room, links
        room = room_for_links(TILE, 2 * len(room.origin), 2 * len(room.link))
