"""Whether gather samples lie on what the camera sees: not on things thinner than their spacing."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from engine.diagnosis import Diagnosis
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.gather_rays import LIFT
from engine.methods.fixed_view.nearest import Grid, nearest
from engine.methods.fixed_view.view import View
from engine.numerics.borrow import borrow
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import add, scale, sub, vec

FAR = 1.5  # spacings to the nearest sample, beyond which it speaks for another place
NEGLIGIBLE = 0.03  # of the picture
OFF = 0.3  # of the indirect light there: thin slats had 29 %


def uncovered(view: View, cloud: GatherCloud, grid: Grid) -> float:
    """Part of the picture that shows surfaces without samples of their own; grid is the cloud's.

    A place is on one if the nearest sample, by position and normal, is FAR away, on another object
    or out of its sight. What shines on it is then gathered, but what it sends is that sample's.
    """
    points = view.points(2)
    seen = np.flatnonzero(points.model >= 0)
    if not len(seen):
        return 0.0
    position, normal = points.position[seen], points.geometric[seen]
    start, way = np.zeros((2, len(seen), 3), np.float32)
    far = np.zeros(len(seen), np.bool_)
    for_ranges(
        _to_nearest, len(seen), grid, position, normal, cloud.points.position,
        cloud.points.geometric, points.object[seen], cloud.points.object, start, way, far,
    )  # fmt: skip
    alone = far | view.scene.rays.occluded(start, way, 1.0)
    return float(alone.sum()) / len(points)


def said_of(share: float, cloud: GatherCloud, later: float) -> Diagnosis | None:
    """What to say of such a part of a picture whose light has bounced to the part `later`."""
    size = OFF * math.sqrt(share) * later
    if share <= NEGLIGIBLE or size <= NEGLIGIBLE:
        return None
    spacing = 100 * cloud.spacing
    return Diagnosis(
        "surfaces_between_samples",
        f"{100 * share:.0f} % of the picture shows surfaces that are thinner or smaller than the "
        f"gather samples lie apart, {spacing:.2g} cm: their indirect light is that of what is "
        "beside them, up to a third off. Set gather_samples higher.",
        size,
    )


@njit(cache=True, nogil=True)
def _to_nearest(
    first, last, grid, position, normal, leaf_position, leaf_normal, obj, leaf_object, start, way,
    far,
):  # fmt: skip
    """Fill start and way (n, 3) from above each place to above its nearest sample.

    far (n,) says whether that one is far away or on another object.
    """
    grid = borrow(grid)
    for i in range(first, last):
        x, g = vec(position, i), vec(normal, i)
        j = nearest(grid, x, g)
        p, spacing = vec(leaf_position, j), np.float64(grid.spacing[j])
        apart = sub(p, x)
        square = apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2]
        far[i] = square > FAR * FAR * spacing * spacing or obj[i] != leaf_object[j]
        above = add(x, scale(g, LIFT * spacing))
        w = sub(add(p, scale(vec(leaf_normal, j), LIFT * spacing)), above)
        for c in range(3):
            start[i, c], way[i, c] = above[c], w[c]
