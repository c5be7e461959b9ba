"""Importance of surfaces: how much of what each of them reflects ends up in the picture.

`direct_to_indirect` §4.1 (Hašan et al. 2006, after Smits, Arvo, Salesin 1992): particles leave the
view samples as paths from the eye would, by what the samples reflect, and bounce about until most
of them are absorbed. Where they land densely, gather samples are worth most. The density at a facet
is that of its neighbourhood: facets are halved, by place and normal, as long as each half still
holds enough particles.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.facets import Facets, facet_at, facet_centres
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.gather_rays import aim
from engine.methods.fixed_view.sides import (
    PARTICLES,
    cosine_rays,
    evenly_chosen,
    sides_met,
    triangle_normals,
)
from engine.methods.fixed_view.surface_points import describe, equivalent_albedo
from engine.numerics.boxes import widest
from engine.numerics.parallel import for_ranges
from engine.scene.scene import Scene

FLIGHTS = 4  # of a particle: that of the final gather, and three bounces
ENOUGH = 128  # particles that make a density: 9 % of noise
BEND = 0.05  # of the scene's size: what turning a normal by 60 degrees counts as


def view_importance(scene: Scene, view: Points, of: Facets, seed: int) -> NDArray[np.float64]:
    """(n,) float64, per m²: density of the view's particles on facets, each by what is left of it.

    In a scene that no view sample is on, all facets count the same.
    """
    count, weight = np.zeros((2, len(of.area)))
    for facet, left in _landings(scene, view, of, seed):
        np.add.at(count, facet, 1)
        np.add.at(weight, facet, left)
    if not weight.any():
        return np.ones(len(of.area))
    turned = np.where(of.back, -1, 1)[:, None] * triangle_normals(scene)[of.triangle]
    features = np.concatenate([facet_centres(scene, of), BEND * scene.diagonal * turned], axis=1)
    density = np.zeros(len(of.area))
    _densities(np.arange(len(density)), features, of.area, count, weight, density)
    return density


def _landings(
    scene: Scene, view: Points, of: Facets, seed: int
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.float64]]]:
    """(facets, what is left of the particles that land on them), flight by flight."""
    points = evenly_chosen(view, PARTICLES)
    n = len(points)
    origin, direction = np.zeros((2, n, 3), np.float32)
    # The first flight follows the view sample's own BRDF, as a path from the eye does.
    first, share, norm = np.zeros(n + 1, np.int32), np.zeros(n, np.float32), np.zeros(n)
    aim(
        np.arange(n, dtype=np.int32), points.position, points.normal, points.geometric,
        points.view, points.model, points.row, scene.rays.epsilon, seed, 1, origin, direction,
        first, share, norm,
    )  # fmt: skip
    flies = np.diff(first) > 0
    left = np.pi / norm[flies]
    origin, direction = origin[: len(left)], direction[: len(left)]
    for flight in range(FLIGHTS):
        hits = scene.rays.intersect(origin, direction)
        side, position, normal = sides_met(scene, hits, direction)
        met = hits.triangle >= 0
        triangle, back = hits.triangle[met], side[met].astype(np.bool_)
        barycentric = np.stack([hits.b1[met], hits.b2[met]], axis=1)
        left = left[met]
        facet = facet_at(of, triangle, back, barycentric)
        yield facet[facet >= 0], left[facet >= 0]
        # What gather samples reflect they reflect as matt surfaces do.
        left = left * equivalent_albedo(describe(scene, triangle, back, barycentric)).mean(axis=1)
        n = len(left)
        origin, direction = np.zeros((2, n, 3), np.float32)
        args = (position[met], normal[met], scene.rays.epsilon, seed + flight, origin, direction)
        for_ranges(cosine_rays, n, *args)


@njit(cache=True, nogil=True)
def _densities(order, features, area, count, weight, density):
    """Fill density (n,): weight over area of groups of facets that hold ENOUGH particles."""
    stack = [(0, order.shape[0])]
    while len(stack) > 0:
        first, last = stack.pop()
        run = order[first:last]
        particles = left = size = 0.0
        for i in run:
            particles, left, size = particles + count[i], left + weight[i], size + area[i]
        cut = 0
        if last - first > 1 and particles >= 2 * ENOUGH:
            # Sort along the feature that varies most, and cut where half of the particles lie.
            feature = widest(features, run)
            run[:] = run[np.argsort(features[run, feature], kind="mergesort")]
            before = 0.0
            while before + count[run[cut]] < 0.5 * particles:
                before += count[run[cut]]
                cut += 1
            # The facet on which the half is reached goes to where it evens things out.
            if before + 0.5 * count[run[cut]] < 0.5 * particles:
                before += count[run[cut]]
                cut += 1
            if min(before, particles - before) < ENOUGH:
                cut = 0
        if cut == 0:
            for i in run:
                density[i] = left / size if size > 0.0 else 0.0
        else:
            stack.append((first, first + cut))
            stack.append((first + cut, last))
