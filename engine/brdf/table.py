"""The table of BRDF models: a new model is one new file and one line in MODELS.

MODELS says which module computes a description. Two descriptions of one formula share a module, so
that it is compiled once: kernels choose among MODULES, and INDEX is a description's place there.
"""

from __future__ import annotations

from types import ModuleType
from typing import Annotated

from pydantic import Field

from engine.brdf import (
    ashikhmin_shirley,
    blinn_phong,
    cook_torrance,
    diffuse,
    ggx,
    half_angle_curve,
    lafortune,
    measured,
    phong,
    poulin_fournier,
    ward,
)
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.brdf.half_angle_curve import HalfAngleCurve
from engine.brdf.lafortune import Lafortune
from engine.brdf.lewis import Lewis
from engine.brdf.measured import Measured
from engine.brdf.phong import Phong
from engine.brdf.poulin_fournier import PoulinFournier
from engine.brdf.ward import Ward
from engine.numerics.dispatch import along, by_index

MODELS: dict[type[Material], ModuleType] = {
    Diffuse: diffuse,
    Phong: phong,
    BlinnPhong: blinn_phong,
    Ggx: ggx,
    AshikhminShirley: ashikhmin_shirley,
    Lafortune: lafortune,
    CookTorrance: cook_torrance,
    HalfAngleCurve: half_angle_curve,
    Lewis: phong,
    Ward: ward,
    PoulinFournier: poulin_fournier,
    Measured: measured,
}

AnyMaterial = Annotated[
    Diffuse
    | Phong
    | BlinnPhong
    | Ggx
    | AshikhminShirley
    | Lafortune
    | CookTorrance
    | HalfAngleCurve
    | Lewis
    | Ward
    | PoulinFournier
    | Measured,
    Field(discriminator="type"),
]

MODULES = tuple(dict.fromkeys(MODELS.values()))
INDEX = {description: MODULES.index(module) for description, module in MODELS.items()}

evaluate = by_index([m.evaluate for m in MODULES], 3)
evaluate_along = by_index([along(m.evaluate) for m in MODULES], 7)
sample = by_index([m.sample for m in MODULES], 3)
pdf = by_index([m.pdf for m in MODULES], 3)
