"""What gloss does that the transfer cannot carry, and how much of it.

Reflections in a view sample are made of gather samples, so they cannot be finer than those lie.
Gather samples send on all their light diffusely (§3.1 of Hašan et al. 2006), so light that a glossy
surface throws onto another, a caustic, is spread evenly instead.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import hemispherical_albedo
from engine.brdf import table as brdfs
from engine.brdf.base import SPECULAR, without_grain
from engine.diagnosis import Diagnosis
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.surface_points import ALBEDO_POINTS
from engine.methods.fixed_view.view import View, gloss_of
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import length, scale, sub
from engine.scene.scene import Scene

DIRECTIONS = 64
ASIDE = math.radians(30)  # from the normal: where a lobe's width is measured
SHARP = math.radians(25)  # width below which what a lobe throws is a caustic and no glow
NEGLIGIBLE = 0.02  # of the picture, or of the light

evaluate, sample, density = brdfs.evaluate, brdfs.sample, brdfs.pdf


def lobe_width(model: NDArray[np.int32], row: NDArray[np.float32]) -> NDArray[np.float64]:
    """(n,) radians: root mean square angle of glossy lobes (n,), (n, ROW) about their mean."""
    kinds, kind = np.unique(
        np.column_stack([model, without_grain(gloss_of(row))[:, SPECULAR + 3 :]]),
        axis=0,
        return_inverse=True,
    )
    lobes = np.zeros((len(kinds), row.shape[1]), np.float32)
    lobes[:, SPECULAR : SPECULAR + 3] = 1  # its colour does not make a lobe wider
    lobes[:, SPECULAR + 3 :] = kinds[:, 1:]
    width = np.zeros(len(kinds))
    for_ranges(_widths, len(kinds), kinds[:, 0].astype(np.int32), lobes, width, grain=16)
    return width[kind.ravel()]


def blurred_mirrors(view: View, cloud: GatherCloud, glossy: NDArray[np.bool_]) -> Diagnosis | None:
    """What to say of reflections that are sharper than the samples they are made of.

    glossy (pixels,) bool marks view samples whose gloss has rows of its own.
    """
    points, pixel = view.buffer.centre, np.flatnonzero(glossy)
    if not len(pixel):
        return None
    normal, towards = points.normal[pixel], points.view[pixel]
    mirror = 2 * np.einsum("ij,ij->i", normal, towards)[:, None] * normal - towards
    origin = points.position[pixel] + view.scene.rays.epsilon * points.geometric[pixel]
    hits = view.scene.rays.intersect(
        np.ascontiguousarray(origin, np.float32), np.ascontiguousarray(mirror, np.float32)
    )
    met = hits.triangle >= 0
    if not met.any():
        return None
    # A lobe is about as wide as two of its standard deviations, where it meets a surface.
    width = lobe_width(points.model[pixel], points.row[pixel])
    footprint = 2 * np.tan(np.minimum(width, 1.2))[met] * hits.distance[met]
    spacing = cloud.spacing
    wider = np.hypot(1, spacing / np.maximum(footprint, 1e-9)) - 1
    share = float((wider > 1).sum()) / len(glossy)
    if share <= NEGLIGIBLE:
        return None
    middle = float(np.median(wider))
    return Diagnosis(
        "mirror_blurred",
        f"{100 * share:.0f} % of the picture mirrors the room so sharply that a point looks more "
        "than twice as wide in it as it should: reflections are made of gather samples, "
        f"{100 * spacing:.2g} cm apart. Four times the gather_samples halve the width; true "
        "mirrors need the reference.",
        middle,
    )


def seen_as_matt(glossy: NDArray[np.bool_]) -> Diagnosis | None:
    """What to say of glossy surfaces in glossy ones; glossy as for `blurred_mirrors`."""
    share = float(glossy.mean())
    if share <= NEGLIGIBLE:
        return None
    return Diagnosis(
        "gloss_seen_as_matt",
        f"Glossy surfaces fill {100 * share:.0f} % of the picture: they reflect the room, but what "
        "they reflect looks matt in them.",
        share,
    )


class Caustics:
    """Weighs the light that sharp gloss would throw on."""

    def __init__(self, scene: Scene, cloud: GatherCloud) -> None:
        """Textures on gloss are not looked up: constants stand for them."""
        table = scene.material_table
        gloss = hemispherical_albedo(table.model, gloss_of(table.row), ALBEDO_POINTS)
        gloss[lobe_width(table.model, table.row) > SHARP] = 0
        thrown = gloss[cloud.points.material] / np.maximum(cloud.albedo, 1e-6)
        self._share = np.minimum(thrown, 1).astype(np.float32) if gloss.any() else None
        self._area = cloud.area

    def __call__(self, first: Callable[[], NDArray[np.float32]]) -> Diagnosis | None:
        """What to say of the light first() (n_g, 3) that the cloud reflects first, or None."""
        if self._share is None:
            return None
        radiance = first()
        total = float(self._area @ radiance.sum(axis=1, dtype=np.float64))
        thrown = float(self._area @ (self._share * radiance).sum(axis=1, dtype=np.float64))
        share = thrown / max(total, 1e-30)
        if share <= NEGLIGIBLE:
            return None
        return Diagnosis(
            "caustics_spread",
            f"{100 * share:.0f} % of the light that surfaces reflect first leaves glossy ones in a "
            "narrow lobe. The caustics that it makes are not in the picture: that much light is "
            "spread evenly instead. No setting brings them; the reference has them.",
            share,
        )


@njit(cache=True, nogil=True)
def _widths(start, stop, model, row, width):
    wo = (math.sin(ASIDE), 0.0, math.cos(ASIDE))
    for i in range(start, stop):
        mx = my = mz = total = 0.0
        for k in range(DIRECTIONS):
            w, weight = _direction(model[i], row[i], wo, k)
            mx, my, mz = mx + weight * w[0], my + weight * w[1], mz + weight * w[2]
            total += weight
        size = length((mx, my, mz))
        if size <= 0.0:
            width[i] = math.pi / 2
            continue
        mean = scale((mx, my, mz), 1.0 / size)
        square = 0.0
        for k in range(DIRECTIONS):
            w, weight = _direction(model[i], row[i], wo, k)
            # 2 sin(a / 2) keeps its digits where an angle is small.
            angle = 2.0 * math.asin(min(1.0, 0.5 * length(sub(w, mean))))
            square += weight * angle * angle
        width[i] = math.sqrt(square / total)


@njit
def _direction(model, row, wo, k):
    """(direction, weight) of one of the directions that a lobe reflects wo from."""
    u = ((0.5 + 0.7548776662 * k) % 1.0, (0.5 + 0.5698402909 * k) % 1.0, 0.5)
    wi = sample(model, row, wo, u)
    p = density(model, row, wi, wo)
    if wi[2] <= 0.0 or p <= 0.0:
        return (0.0, 0.0, 1.0), 0.0
    f = evaluate(model, row, wi, wo)
    return wi, (f[0] + f[1] + f[2]) * wi[2] / p
