"""The gather cloud: points on all exposed surfaces that collect direct light and pass it on.

`direct_to_indirect` §4.1 (Hašan et al. 2006). They lie evenly, or in proportion to the importance
of surfaces to the picture. Where they lie thinly each stands for more area, so that sums over the
cloud are the same either way.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import ROW
from engine.brdf.diffuse import Diffuse
from engine.brdf.table import INDEX
from engine.errors import SceneError
from engine.methods.fixed_view.facets import Facets, draw, facet_centres, facets, on_triangles
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.hierarchy import Clusters, build_order, describe_clusters
from engine.methods.fixed_view.sides import exposed_sides, looks_out, triangle_areas
from engine.methods.fixed_view.surface_points import describe, equivalent_albedo
from engine.methods.fixed_view.view_importance import view_importance
from engine.scene.scene import Scene

Spread = Literal["uniform", "importance"]

# Importance may vary over parts of large triangles, this many of all area in a scene.
PARTS = 4096
# Part of the samples that importance has no say in: light may come from anywhere, and so no sample
# stands for more than the inverse of this many times the mean area.
EVEN = 0.2
_STORED = ("position", "normal", "geometric", "object", "material")


@dataclass(frozen=True)
class GatherCloud:
    """n_g = 4^k gather samples in the order of their cluster hierarchy.

    points    n_g points with a diffuse BRDF of reflectance `albedo`, seen along their normals
    albedo    (n_g, 3) float32  what the surface reflects in all, its gloss counted as diffuse
    emission  (n_g, 3) float32  radiance that the surface emits
    area      (n_g,) float32    m² that each sample stands for
    clusters  the quad-tree over the samples
    """

    points: Points
    albedo: NDArray[np.float32]
    emission: NDArray[np.float32]
    area: NDArray[np.float32]
    clusters: Clusters

    def __len__(self) -> int:
        return len(self.albedo)

    @property
    def spacing(self) -> float:
        """Metres from one sample to the next, on the average of all surfaces."""
        return math.sqrt(float(self.area.mean(dtype=np.float64)))


def build_cloud(
    scene: Scene, view: Points, count: int, position_weight: float, spread: Spread, seed: int
) -> GatherCloud:
    """Sample `count` = 4^k points on the sides that the view's particles touch."""
    sides = exposed_sides(scene, view, seed)
    total = float((sides.sum(axis=1) * triangle_areas(scene)).sum())
    if total <= 0:
        raise SceneError("no surface of the scene has an area", field="objects")
    of = facets(scene, sides, total / PARTS if spread == "importance" else np.inf)
    weight = of.area.copy()
    if spread == "importance":
        weight *= _frequency(of, view_importance(scene, view, of, seed))
    centre = facet_centres(scene, of)

    # Draw facets and places on them until enough of the places look out on the scene.
    for candidates in (count, 2 * count, 8 * count):
        picked, place = draw(centre, weight, candidates, seed)
        barycentric = on_triangles(of, picked, place)
        points = describe(scene, of.triangle[picked], of.back[picked], barycentric)
        good = np.flatnonzero(looks_out(scene, points.position, points.geometric, sides, seed))
        if len(good) >= count:
            break
    if len(good) == 0:
        good = np.arange(candidates)
    # They are in spatial order, so an even choice of them stays even.
    kept = good[np.linspace(0, len(good) - 1, count).astype(np.intp)]
    # Of n draws of which a facet gets n w / Σ w, each stands for its area over that number.
    area = (of.area / weight)[picked[kept]] * (weight.sum() / candidates * len(good) / count)
    points = points.take(kept)
    order = build_order(points.position, points.normal, scene.diagonal, position_weight)
    points = points.take(order)
    return cloud_from(
        {
            "position": points.position,
            "normal": points.normal,
            "geometric": points.geometric,
            "albedo": equivalent_albedo(points),
            "emission": scene.material_table.emission[points.material],
            "area": area[order].astype(np.float32),
            "object": points.object,
            "material": points.material,
        }
    )


def _frequency(of: Facets, importance: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n,) samples for an area of each facet, against their mean."""
    mean = float((importance * of.area).sum() / of.area.sum())
    return EVEN + (1 - EVEN) * importance / mean


def cloud_from(arrays: Mapping[str, NDArray[Any]]) -> GatherCloud:
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
        size=np.sqrt(arrays["area"]),
    )
    clusters = describe_clusters(points.position, points.normal, arrays["area"])
    return GatherCloud(points, arrays["albedo"], arrays["emission"], arrays["area"], clusters)


def cloud_arrays(cloud: GatherCloud) -> dict[str, NDArray[Any]]:
    """What `cloud_from` needs."""
    points = {name: getattr(cloud.points, name) for name in _STORED}
    return {**points, "albedo": cloud.albedo, "emission": cloud.emission, "area": cloud.area}
