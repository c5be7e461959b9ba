"""Measured materials that come with the engine: what a goniometer would find of three models.

They are those that Claustres et al. 2007, §6.1, test with: an isotropic plastic, a brushed metal,
and cloth of parallel threads.
"""

from __future__ import annotations

from engine.brdf.acquisition import Measurement, of_material
from engine.brdf.base import Material
from engine.brdf.lewis import Lewis
from engine.brdf.poulin_fournier import PoulinFournier
from engine.brdf.ward import Ward

DARK = (0.0, 0.0, 0.0)

BUILT_IN: dict[str, Material] = {
    "plastic": Lewis(
        emission=DARK, diffuse=(0.4, 0.1, 0.05), specular=(0.3, 0.3, 0.3), exponent=40
    ),
    "brushed": Ward(
        emission=DARK,
        diffuse=(0.1, 0.09, 0.08),
        specular=(0.5, 0.45, 0.4),
        roughness=0.4,
        roughness_v=0.15,
    ),
    "threads": PoulinFournier(emission=DARK, diffuse=(0.5, 0.3, 0.1), specular=(0.3, 0.3, 0.3)),
}


def measured(name: str) -> Measurement:
    """The measurement of one of BUILT_IN."""
    return of_material(BUILT_IN[name])
