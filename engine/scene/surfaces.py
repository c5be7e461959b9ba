"""A material with its images."""

from __future__ import annotations

from dataclasses import dataclass, field

from engine.brdf.base import Material
from engine.scene.textures import Image


@dataclass(frozen=True, eq=False)
class Surface:
    """A material's constants and the images that multiply them, by slot."""

    material: Material
    images: dict[str, Image] = field(default_factory=dict)
