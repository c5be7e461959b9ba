"""The table of BRDF models: a new model is one new file and one line in MODELS."""

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
    phong,
)
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.brdf.half_angle_curve import HalfAngleCurve
from engine.brdf.lafortune import Lafortune
from engine.brdf.phong import Phong
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
}

AnyMaterial = Annotated[
    Diffuse
    | Phong
    | BlinnPhong
    | Ggx
    | AshikhminShirley
    | Lafortune
    | CookTorrance
    | HalfAngleCurve,
    Field(discriminator="type"),
]

INDEX = {description: index for index, description in enumerate(MODELS)}

evaluate = by_index([m.evaluate for m in MODELS.values()], 3)
evaluate_along = by_index([along(m.evaluate) for m in MODELS.values()], 7)
sample = by_index([m.sample for m in MODELS.values()], 3)
pdf = by_index([m.pdf for m in MODELS.values()], 3)
