"""The gather cloud: points on all exposed surfaces that collect direct light and pass it on.

`direct_to_indirect` §4.1 (Hašan et al. 2006), uniform sampling: the sides of triangles are split by
axis-aligned planes into halves of equal area, the budget with them, until one side is left, which
is sampled uniformly, or a budget of one, for which a side is drawn by area.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import hemispherical_albedo
from engine.brdf.base import ROW, without_grain
from engine.brdf.diffuse import Diffuse
from engine.brdf.table import INDEX
from engine.errors import SceneError
from engine.methods.fixed_view.frame_buffer import Points, no_points
from engine.methods.fixed_view.hierarchy import Clusters, build_order, describe_clusters
from engine.methods.fixed_view.sides import exposed_sides, looks_out, triangle_areas
from engine.numerics.parallel import for_ranges
from engine.numerics.sampling import uniform
from engine.numerics.vec import scale
from engine.scene import surface
from engine.scene.scene import Scene

ALBEDO_POINTS = 256
_STORED = ("position", "normal", "geometric", "object", "material")


@dataclass(frozen=True)
class GatherCloud:
    """n_g = 4^k gather samples in the order of their cluster hierarchy.

    points    n_g points with a diffuse BRDF of reflectance `albedo`, seen along their normals
    albedo    (n_g, 3) float32  what the surface reflects in all, its gloss counted as diffuse
    emission  (n_g, 3) float32  radiance that the surface emits
    area      float             m² that one sample stands for; the same for all of them
    clusters  the quad-tree over the samples
    """

    points: Points
    albedo: NDArray[np.float32]
    emission: NDArray[np.float32]
    area: float
    clusters: Clusters

    def __len__(self) -> int:
        return len(self.albedo)


def build_cloud(
    scene: Scene, view: Points, count: int, position_weight: float, seed: int
) -> GatherCloud:
    """Sample `count` = 4^k points on the sides that the view's particles touch."""
    sides = exposed_sides(scene, view, seed)
    items = np.flatnonzero(sides.ravel()).astype(np.int32)  # 2 * triangle + side
    area = triangle_areas(scene)
    centre = scene.geometry.positions[scene.geometry.triangles].mean(axis=1, dtype=np.float64)
    total = float(area[items // 2].sum())
    if total <= 0:
        raise SceneError("no surface of the scene has an area", field="objects")

    # Draw sides and places on them until enough of the places look out on the scene.
    for candidates in (count, 2 * count, 8 * count):
        picked = np.zeros(candidates, np.int32)
        barycentric = np.zeros((candidates, 2), np.float32)
        args = (items.copy(), centre, area, candidates, seed, picked, barycentric)
        _split_and_sample(*args)
        points = _describe(scene, picked // 2, (picked & 1).astype(np.bool_), barycentric)
        good = np.flatnonzero(looks_out(scene, points.position, points.geometric, sides, seed))
        if len(good) >= count:
            break
    if len(good) == 0:
        good = np.arange(candidates)
    # They are in spatial order, so an even choice of them stays even.
    points = points.take(good[np.linspace(0, len(good) - 1, count).astype(np.intp)])
    total *= len(good) / candidates
    order = build_order(points.position, points.normal, scene.diagonal, position_weight)
    points = points.take(order)
    arrays = {
        "position": points.position,
        "normal": points.normal,
        "geometric": points.geometric,
        "albedo": equivalent_albedo(points),
        "emission": scene.material_table.emission[points.material],
        "object": points.object,
        "material": points.material,
    }
    return cloud_from(arrays, total / count)


def cloud_from(arrays: Mapping[str, NDArray[Any]], area: float) -> GatherCloud:
    """The cloud of arrays in tree order, as `cloud_arrays` gives them."""
    n = len(arrays["position"])
    row = np.zeros((n, ROW), np.float32)
    row[:, :3] = arrays["albedo"]
    points = Points(
        position=arrays["position"],
        normal=arrays["normal"],
        geometric=arrays["geometric"],
        view=arrays["normal"],
        model=np.full(n, INDEX[Diffuse], np.int32),
        row=row,
        object=arrays["object"],
        material=arrays["material"],
        phase=(np.arange(n) % 16).astype(np.uint8),
        size=np.full(n, np.sqrt(area), np.float32),
    )
    clusters = describe_clusters(points.position, points.normal, area)
    return GatherCloud(points, arrays["albedo"], arrays["emission"], area, clusters)


def cloud_arrays(cloud: GatherCloud) -> dict[str, NDArray[Any]]:
    """What `cloud_from` needs besides the area."""
    points = {name: getattr(cloud.points, name) for name in _STORED}
    return {**points, "albedo": cloud.albedo, "emission": cloud.emission}


def equivalent_albedo(points: Points) -> NDArray[np.float32]:
    """(n, 3) float32: hemispherical albedo of each point's whole BRDF, gloss included."""
    # An albedo is linear in the diffuse colour, so two per kind of gloss give it for any texture.
    kinds, kind = np.unique(
        np.column_stack([points.model, without_grain(points.row)[:, 3:]]),
        axis=0,
        return_inverse=True,
    )
    model = kinds[:, 0].astype(np.int32)
    row = np.zeros((len(kinds), ROW), np.float32)
    row[:, 3:] = kinds[:, 1:]
    black = hemispherical_albedo(model, row, ALBEDO_POINTS)
    row[:, :3] = 1
    white = hemispherical_albedo(model, row, ALBEDO_POINTS)
    diffuse = points.row[:, :3]
    return (black[kind] + diffuse * (white - black)[kind]).astype(np.float32)


def _describe(
    scene: Scene,
    triangle: NDArray[np.int32],
    back: NDArray[np.bool_],
    barycentric: NDArray[np.float32],
) -> Points:
    """Points (n) on the front or back of triangles (n,), seen along their normals."""
    n = len(triangle)
    points = no_points(n)
    for_ranges(
        _describe_samples, n, scene.geometry, scene.material_table, triangle, back, barycentric,
        points.position, points.normal, points.geometric, points.view, points.model, points.row,
        points.object, points.material,
    )  # fmt: skip
    return points


@njit(cache=True, nogil=True)
def _describe_samples(
    start, stop, geometry, materials, triangle, back, barycentric,
    position, normal, geometric, view, model, row, obj, material,
):  # fmt: skip
    for i in range(start, stop):
        t, b1, b2 = triangle[i], barycentric[i, 0], barycentric[i, 1]
        p = surface.position(geometry, t, b1, b2)
        g = surface.geometric_normal(geometry, t)
        if back[i]:
            g = scale(g, -1.0)
        _, s = surface.normals(geometry, t, b1, b2, g)
        model[i] = surface.parameters(geometry, materials, t, b1, b2, s, row[i])
        obj[i] = geometry.object[t]
        material[i] = geometry.material[t]
        for k in range(3):
            position[i, k] = p[k]
            normal[i, k] = s[k]
            geometric[i, k] = g[k]
            view[i, k] = s[k]


@njit(cache=True, nogil=True)
def _split_and_sample(items, centre, area, count, seed, picked, barycentric):
    """Fill picked (count,) with items and barycentric (count, 2) with places on them."""
    stack = [(0, items.shape[0], 0, count)]
    while len(stack) > 0:
        first, last, out, budget = stack.pop()
        run = items[first:last]
        if budget == 1 or last - first == 1:
            _sample_run(run, area, out, budget, seed, picked, barycentric)
            continue

        # Sort along the longest axis of the box around the centres.
        axis, best = 0, -1.0
        for k in range(3):
            low = high = centre[run[0] // 2, k]
            for i in run:
                low, high = min(low, centre[i // 2, k]), max(high, centre[i // 2, k])
            if high - low > best:
                axis, best = k, high - low
        key = np.zeros(len(run))
        for j in range(len(run)):
            key[j] = centre[run[j] // 2, axis]
        run[:] = run[np.argsort(key, kind="mergesort")]

        # Cut where half of the area lies on each side, and round the budget's halves at random.
        total = 0.0
        for i in run:
            total += area[i // 2]
        cut, left = 0, 0.0
        while cut < len(run) - 1 and (cut == 0 or left + 0.5 * area[run[cut] // 2] < 0.5 * total):
            left += area[run[cut] // 2]
            cut += 1
        share = budget * left / total if total > 0.0 else 0.0
        part = int(share)
        if uniform(seed, out, budget) < share - part:
            part += 1
        if part > 0:
            stack.append((first, first + cut, out, part))
        if budget - part > 0:
            stack.append((first + cut, last, out + part, budget - part))


@njit
def _sample_run(run, area, out, budget, seed, picked, barycentric):
    # One sample among several sides: draw the side by area.
    item = run[0]
    if len(run) > 1:
        total = 0.0
        for i in run:
            total += area[i // 2]
        threshold = uniform(seed, out, 1000000) * total
        for i in run:
            threshold -= area[i // 2]
            if threshold <= 0.0:
                item = i
                break

    # Several samples on one side: the plastic-number sequence spreads them evenly (Roberts 2018).
    shift1, shift2 = uniform(seed, out, 1000001), uniform(seed, out, 1000002)
    for k in range(budget):
        u1 = (shift1 + k * 0.7548776662466927) % 1.0
        u2 = (shift2 + k * 0.5698402909980532) % 1.0
        # Folding the square keeps the even spread, which a square root would stretch.
        if u1 + u2 > 1.0:
            u1, u2 = 1.0 - u1, 1.0 - u2
        picked[out + k] = item
        barycentric[out + k, 0] = u1
        barycentric[out + k, 1] = u2
