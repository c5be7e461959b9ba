"""What a precompute measures of its own result, and what users are told of it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from engine.brdf.diffuse import Diffuse
from engine.diagnosis import Diagnosis
from engine.scene.scene import Scene
from engine.scene.surface import NORMAL_MAP

LEFT = 0.02  # of all light: less is not worth a warning
OFF = 0.05  # relative error of shadows of a small lamp: less is not worth a warning


class Measured(NamedTuple):
    """Relative errors.

    left     part of all light that passes which were not made would bring
    between  of shadows between vertices, see `coarseness.between_vertices`
    simpler  of shadows of a simpler model, see `coarseness.of_simpler`; 0 where there is none
    """

    left: float
    between: float
    simpler: float


def said_of(scene: Scene, measured: Measured) -> Iterator[Diagnosis]:
    """What all frames of a scene come with."""
    left, between, simpler = measured
    if any(light.enabled for light in scene.lights):
        yield Diagnosis(
            "lights_left_out",
            "This method carries light from the environment alone: the scene's lamps are left out. "
            "direct_to_indirect carries them, for a camera that stands still.",
        )
    maps = scene.material_table.maps >= 0
    linear = np.array([m.gloss_is_linear for m in scene.materials])
    glossy = np.array([not isinstance(m, Diffuse) for m in scene.materials])
    varies = (maps[:, 1] & ~linear & glossy) | (maps[:, 2] & glossy) | maps[:, NORMAL_MAP]
    if varies.any():
        names = ", ".join(repr(scene.material_names[m]) for m in np.flatnonzero(varies))
        yield Diagnosis(
            "textures_left_out",
            f"The gloss of {names} is taken as even and the surface as smooth: of textures this "
            "method carries those of reflectances that are factors of the BRDF, none of roughness "
            "or of normals. direct_to_indirect carries them, for a camera that stands still.",
        )
    if left >= LEFT:
        yield Diagnosis(
            "bounces_truncated",
            f"Light that bounces more often than it was followed would add {100 * left:.0f} % or "
            "more to what there is: set bounces higher.",
            left,
        )
    if between >= OFF:
        yield Diagnosis(
            "mesh_too_coarse",
            f"Between the vertices of the mesh a light of 10 degrees is {100 * between:.0f} % off, "
            "as measured at some of them: shadows are as sharp as triangles are small. Cut the "
            "mesh more finely; rectangles have `segments`.",
            between,
        )
    if simpler >= OFF:
        yield Diagnosis(
            "occluders_too_simple",
            f"Shadows are those of a simpler model: a light of 10 degrees is {100 * simpler:.0f} % "
            "off at the vertices, as measured at some of them. Set occluder_vertices higher, or to "
            "0 for the scene itself.",
            simpler,
        )
