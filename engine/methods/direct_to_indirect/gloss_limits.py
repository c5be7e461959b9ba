"""How wide lobes are, and what surfaces throw on that the transfer cannot carry.

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
from engine.methods.fixed_view.view import gloss_of
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

    def __call__(self, first: Callable[[], NDArray[np.float32]], later: float) -> Diagnosis | None:
        """What to say of the light first() (n_g, 3) that the cloud reflects first, or None.

        later is the part of all light that has bounced. Caustics are bright where they are, so by
        the norm of a picture they are more than that: its root, as found in three scenes.
        """
        if self._share is None:
            return None
        radiance = first()
        total = float(self._area @ radiance.sum(axis=1, dtype=np.float64))
        thrown = float(self._area @ (self._share * radiance).sum(axis=1, dtype=np.float64))
        share = thrown / max(total, 1e-30)
        size = share * math.sqrt(later)
        if size <= NEGLIGIBLE:
            return None
        return Diagnosis(
            "caustics_spread",
            f"{100 * share:.0f} % of the light that surfaces reflect first leaves glossy ones in a "
            "narrow lobe. The caustics that it makes are not in the picture: that much light is "
            "spread evenly instead. No setting brings them; the reference has them.",
            size,
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
