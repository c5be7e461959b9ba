"""The table of BRDF models: a new model is one new file and one line in MODELS."""

from __future__ import annotations

from types import ModuleType

from engine.brdf import diffuse
from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.numerics.dispatch import by_index

MODELS: dict[type[Material], ModuleType] = {
    Diffuse: diffuse,
}

AnyMaterial = Diffuse  # the union of all descriptions, discriminated by `type`

INDEX = {description: index for index, description in enumerate(MODELS)}

evaluate = by_index([m.evaluate for m in MODELS.values()], 3)
sample = by_index([m.sample for m in MODELS.values()], 3)
pdf = by_index([m.pdf for m in MODELS.values()], 3)
