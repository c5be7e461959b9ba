"""What a view's gloss mirrors, and what is lost of that.

Reflections in a view sample are made of gather samples, so they cannot be finer than those lie; and
gather samples send on all light diffusely (§3.1 of Hašan et al. 2006), so gloss that is mirrored
looks matt.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf import hemispherical_albedo
from engine.diagnosis import Diagnosis
from engine.methods.direct_to_indirect.gloss_limits import NEGLIGIBLE, lobe_width
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.surface_points import ALBEDO_POINTS
from engine.methods.fixed_view.view import View, gloss_of

Array = NDArray[np.float64]
# Of what points would be off: a spot on a wall in a mirror was 0.66 of that, evener things 0.23.
LIKE_POINTS = 0.5
MATT = 0.25  # rad: gloss so wide that it looks half matt already


class Mirrored(NamedTuple):
    """What k pixels with gloss show along their mirror directions.

    pixels    int, of the whole picture
    share     (k,) part of what a pixel reflects that its gloss does
    width     (k,) rad: `lobe_width` of the gloss
    distance  (k,) metres to what is mirrored, infinite where nothing is
    gloss     (k,) part of that one's albedo that is gloss, less the wider its lobe; 0 for nothing
    """

    pixels: int
    share: Array
    width: Array
    distance: Array
    gloss: Array


def mirrored_by(view: View, glossy: NDArray[np.bool_]) -> Mirrored:
    """glossy (pixels,) bool marks view samples whose gloss has rows of its own."""
    points, pixel = view.buffer.centre, np.flatnonzero(glossy)
    if not len(pixel):
        return Mirrored(len(glossy), *np.zeros((4, 0)))
    matt, gloss = (part[pixel].mean(axis=1, dtype=np.float64) for part in view.reflectance)
    normal, towards = points.normal[pixel], points.view[pixel]
    mirror = 2 * np.einsum("ij,ij->i", normal, towards)[:, None] * normal - towards
    origin = points.position[pixel] + view.scene.rays.epsilon * points.geometric[pixel]
    hits = view.scene.rays.intersect(
        np.ascontiguousarray(origin, np.float32), np.ascontiguousarray(mirror, np.float32)
    )
    met = hits.triangle >= 0
    seen = np.zeros(len(pixel))
    seen[met] = _gloss_of_materials(view)[view.scene.geometry.material[hits.triangle[met]]]
    return Mirrored(
        len(glossy),
        gloss / np.maximum(matt + gloss, 1e-9),
        lobe_width(points.model[pixel], points.row[pixel]),
        np.where(met, hits.distance, np.inf).astype(np.float64),
        seen,
    )


def _gloss_of_materials(view: View) -> Array:
    """(materials,): part of their albedo that is gloss, less the wider its lobe."""
    table = view.scene.material_table
    whole, gloss = (
        hemispherical_albedo(table.model, row, ALBEDO_POINTS).mean(axis=1)
        for row in (table.row, gloss_of(table.row))
    )
    sharp = 1 / (1 + (lobe_width(table.model, table.row) / MATT) ** 2)
    return np.asarray(sharp * gloss / np.maximum(whole, 1e-9))


def blurred_mirrors(mirrored: Mirrored, cloud: GatherCloud) -> Diagnosis | None:
    """What to say of reflections that are sharper than the samples they are made of.

    Its size is a part of the error of a picture where all that is mirrored is points.
    """
    met = np.isfinite(mirrored.distance)
    # A lobe is about as wide as two of its standard deviations, where it meets a surface.
    footprint = 2 * np.tan(np.minimum(mirrored.width, 1.2))[met] * mirrored.distance[met]
    wider = np.hypot(1, cloud.spacing / np.maximum(footprint, 1e-9))
    share = float((wider > 2).sum()) / mirrored.pixels
    if share <= NEGLIGIBLE:
        return None
    # Of two normal distributions of the same light, one so many times as wide as the other.
    off = 1 + wider**-2 - 4 / (1 + wider**2)
    points = math.sqrt(float((mirrored.share[met] ** 2 * off).sum()) / mirrored.pixels)
    return Diagnosis(
        "mirror_blurred",
        f"{100 * share:.0f} % of the picture mirrors the room so sharply that a point looks more "
        "than twice as wide in it as it should: reflections are made of gather samples, "
        f"{100 * cloud.spacing:.2g} cm apart. Four times the gather_samples halve the width; true "
        "mirrors need the reference.",
        LIKE_POINTS * points,
    )


def seen_as_matt(mirrored: Mirrored) -> Diagnosis | None:
    """What to say of gloss that is seen in gloss."""
    off = mirrored.share * mirrored.gloss
    size = math.sqrt(float((off**2).sum()) / max(1, mirrored.pixels))
    if size <= NEGLIGIBLE:
        return None
    return Diagnosis(
        "gloss_seen_as_matt",
        f"Glossy surfaces mirror other glossy ones, which look matt in them: up to {100 * size:.0f}"
        " % of the picture is off by that. The reference has it, and brdf_editing with "
        "second_bands.",
        size,
    )
