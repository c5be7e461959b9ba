"""The gather matrix the obvious way: dense, from the kernels' own links, or in closed form."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from engine.methods.fixed_view.gather import Job, cosine_lobes
from engine.methods.fixed_view.hierarchy import Clusters, build_order, describe_clusters
from engine.methods.fixed_view.links import Links, find_links, hide, room_for_links
from engine.methods.fixed_view.packing import pack
from engine.methods.fixed_view.rows import PackedRows, make_scratch, project
from engine.numerics.haar import forward, inverse
from engine.numerics.packed import STEPS, TILE, step_units
from engine.scene.rays import RayTracer

LINK, PATCH = 0.05, 0.5


class Cloud(NamedTuple):
    """Gather samples in tree order."""

    position: np.ndarray
    normal: np.ndarray
    clusters: Clusters


def cloud(position: np.ndarray, normal: np.ndarray, area: float | np.ndarray) -> Cloud:
    """Samples (n, 3) with normals (n, 3), of `area` m² each, or (n,)."""
    position = np.ascontiguousarray(position, np.float32)
    normal = np.ascontiguousarray(np.broadcast_to(normal, position.shape), np.float32)
    diagonal = float(np.linalg.norm(np.ptp(position, axis=0)))
    order = build_order(position, normal, diagonal, 6.0)
    position, normal = position[order], normal[order]
    area = np.broadcast_to(np.float32(area), len(order))[order]
    return Cloud(position, normal, describe_clusters(position, normal, area))


def square(n: int, centre: tuple, u: tuple, v: tuple, normal: tuple) -> Cloud:
    """n x n samples on the square centre ± u ± v."""
    s = (np.arange(n) + 0.5) / n * 2 - 1
    a, b = np.meshgrid(s, s)
    position = np.array(centre) + a.reshape(-1, 1) * np.array(u) + b.reshape(-1, 1) * np.array(v)
    area = 4 * np.linalg.norm(np.cross(u, v)) / n**2
    return cloud(position, np.array(normal, float), float(area))


def links_of(points: np.ndarray, normals: np.ndarray, samples: Cloud) -> tuple[Links, int]:
    """Links of points (b, 3), unblocked, and their number."""
    points = np.ascontiguousarray(points, np.float32)
    normals = np.ascontiguousarray(normals, np.float32)
    room = room_for_links(len(points), 1 << 16, 1 << 18)
    count = find_links(
        np.arange(len(points), dtype=np.int32), points, normals, normals, samples.position,
        samples.normal, samples.clusters, LINK, PATCH, 1e-4, 1, room,
    )  # fmt: skip
    assert count >= 0, "no room"
    return room, count


def dense_rows(room: Links, blocked: np.ndarray, samples: Cloud) -> np.ndarray:
    """(b, n_g) float64: F of every sample for every point, patch by patch."""
    depth = samples.clusters.depth
    rows = np.zeros((len(room.first) - 1, len(samples.position)))
    for b in range(len(rows)):
        for p in range(room.first[b], room.first[b + 1]):
            if not blocked[room.link[p]]:
                level = 0
                while (4 ** (level + 1) - 1) // 3 <= room.cluster[p]:
                    level += 1
                j, run = room.cluster[p] - (4**level - 1) // 3, 4 ** (depth - level)
                rows[b, j * run : (j + 1) * run] += room.weight[p]
    return rows


def projected(room: Links, blocked: np.ndarray, samples: Cloud):
    """(ids, values, starts) of `project`."""
    ids, values = np.zeros(1 << 19, np.int32), np.zeros(1 << 19, np.float32)
    starts = np.zeros(len(room.first), np.int64)
    scratch = make_scratch(len(samples.position))
    weight = room.weight.copy()
    hide(room.first, room.link, weight, blocked)
    count = project(
        room.first, room.cluster, weight, samples.clusters.depth, scratch, ids, values, starts
    )
    assert count >= 0, "no room"
    assert not scratch.scaling.any()
    assert not scratch.touched.any()
    return ids[:count], values[:count], starts


def packed(
    ids, values, starts, n: int, coefficients: int, importance=None, wanted=None, noise=0.0
):  # fmt: skip
    """(PackedRows of one tile, share of energy kept)."""
    importance = np.ones(n, np.float32) if importance is None else importance
    noise = np.full((4 * n - 1) // 3, noise)
    wanted = np.ones(TILE, np.bool_) if wanted is None else wanted
    most = min(8 * coefficients, 4 * n)
    wavelets, (mean, scale) = np.zeros(most, np.int32), np.zeros((2, most), np.float32)
    steps, length = np.zeros(most * TILE, np.int8), np.zeros((1, len(STEPS)), np.int32)
    scratch = make_scratch(n)
    count, size, kept = pack(
        ids, values, starts, wanted, importance, noise, coefficients, scratch, length[0], wavelets,
        mean, scale, steps,
    )  # fmt: skip
    assert not scratch.energy.any()
    assert (scratch.slot == -1).all()
    assert count == length.sum()
    assert size == length[0] @ STEPS
    scale = scale[: length[:, :-1].sum()]
    rows = PackedRows(length, wavelets[:count], mean[:count], scale, steps[:size])
    return rows, kept


def steps_of(rows: PackedRows) -> list[np.ndarray]:
    """The steps of every wavelet."""
    count = np.concatenate([np.repeat(STEPS, tile) for tile in rows.length])
    return np.split(rows.steps, np.cumsum(count)[:-1]) if len(count) else []


def scales_of(rows: PackedRows) -> np.ndarray:
    """(q,): the scale of every wavelet, 0 where it has no steps."""
    scales = np.zeros(len(rows.ids))
    scales[[len(steps) > 0 for steps in steps_of(rows)]] = rows.scale
    return scales


def unpacked(rows: PackedRows, n: int, points: int = TILE) -> np.ndarray:
    """(tiles * points, n) float64: the rows in wavelet space, dense."""
    out = np.zeros((len(rows.length), TILE, n))
    tile = np.repeat(np.arange(len(rows.length)), rows.length.sum(axis=1))
    for k, (steps, scale) in enumerate(zip(steps_of(rows), scales_of(rows), strict=True)):
        over_tile = np.zeros((TILE, 1))
        over_tile[: len(steps), 0] = scale * steps
        over_tile[0] = rows.mean[k]
        out[tile[k], :, rows.ids[k]] += inverse(over_tile * step_units()[:, None])[:, 0]
    return out[:, :points].reshape(-1, n)


def haar_rows(rows: np.ndarray) -> np.ndarray:
    """Dense rows (b, n) to wavelet space."""
    return forward(np.ascontiguousarray(rows.T)).T


def job(samples: Cloud, points: np.ndarray, normals: np.ndarray, rays: RayTracer, **fields) -> Job:
    """A job over points in runs of 64, with shadow rays."""
    runs = np.arange(len(points), dtype=np.int32).reshape(-1, TILE)
    settings = {
        "positions": np.zeros((0, 3), np.float32),
        "triangles": np.zeros((0, 3), np.int32),
        "importance": np.ones(len(samples.position), np.float32),
        "lobes": cosine_lobes(np.ascontiguousarray(normals, np.float32)),
        "count": 0,
        "link_size": LINK,
        "patch_size": PATCH,
        "coefficients": 4096,
        "environment_coefficients": 4096,
        "seed": 1,
        **fields,
    }
    return Job(
        tiles=runs,
        position=np.ascontiguousarray(points, np.float32),
        normal=np.ascontiguousarray(normals, np.float32),
        geometric=np.ascontiguousarray(normals, np.float32),
        leaf_position=samples.position,
        leaf_geometric=samples.normal,
        clusters=samples.clusters,
        rays=rays,
        **settings,
    )
