"""What a scene says of materials that reflect more than they receive."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from engine.brdf.albedo import albedo_diagnosis
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.brdf.half_angle_curve import HalfAngleCurve
from engine.brdf.phong import Phong
from engine.brdf.poulin_fournier import PoulinFournier
from engine.brdf.ward import Ward
from engine.diagnosis import Diagnosis
from engine.scene.scene import MaterialTable


def albedo_diagnoses(
    names: Sequence[str], materials: Sequence[Material], table: MaterialTable
) -> list[Diagnosis]:
    """What to say of materials that reflect more than they receive."""
    found = []
    for m, (name, material) in enumerate(zip(names, materials, strict=True)):
        # Measuring takes a while, so leave out what is never told of: models that conserve energy,
        # and lobes that reflect no more than their colour, where that and the base's add up to 1.
        if isinstance(material, Diffuse | Ggx | AshikhminShirley | CookTorrance | HalfAngleCurve):
            continue
        if isinstance(material, Phong | BlinnPhong | Ward | PoulinFournier) and (
            np.max(np.add(material.diffuse, material.specular)) <= 1.0 + 1e-6
        ):
            continue
        diagnosis = albedo_diagnosis(name, int(table.model[m]), table.row[m])
        if diagnosis is not None:
            found.append(diagnosis)
    return found
