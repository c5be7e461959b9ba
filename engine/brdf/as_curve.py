"""A material as one whose curve a hand can bend: the half-angle curve nearest to its lobe."""

from __future__ import annotations

import numpy as np

from engine.brdf.base import Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.curve_basis import coefficients
from engine.brdf.half_angle_curve import NODES, HalfAngleCurve, cover
from engine.brdf.layers import LAYERS
from engine.brdf.phong import Phong
from engine.brdf.table import INDEX

DIGITS = 4  # behind the point, of a node


def as_curve(material: Material) -> HalfAngleCurve:
    """The material with its lobe as a curve that covers the surface; its colours are kept.

    A lobe about the mirrored view is as wide as one of four times its exponent about the half
    angle, and a brushed one gets that along its grain. Models without a lobe, or with one that has
    no half angle, get the default curve.
    """
    if isinstance(material, HalfAngleCurve):
        return material
    if isinstance(material, Phong):
        fields = material.model_dump(exclude={"type", "exponent"})
        material = BlinnPhong(**fields, exponent=min(4 * material.exponent, 1e5))
    kept = material.model_dump(include={"emission", "diffuse"})
    layers = LAYERS[INDEX[type(material)]]
    if layers is None or layers.curves == 0:
        return HalfAngleCurve(**kept)
    white = material.model_copy(update={"specular": (1.0, 1.0, 1.0)}).row()
    # The nearest tents may be a little less than none where a lobe is steep.
    lobe = np.maximum(0, coefficients(layers, white, NODES, "tents")[1][0, :, 0])
    curve = tuple(round(float(value), DIGITS) for value in lobe / cover(lobe))
    return HalfAngleCurve(**kept, specular=material.model_dump()["specular"], curve=curve)
