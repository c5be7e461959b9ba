"""What a precompute measures of its own result, and what users are told of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf.diffuse import Diffuse
from engine.diagnosis import Diagnosis
from engine.methods.glossy_prt.coarseness import RADIUS
from engine.methods.light_shares import light_shares
from engine.numerics import cube_map
from engine.scene.scene import Scene
from engine.scene.surface import NORMAL_MAP

LEFT = 0.02  # of all light: less is not worth a warning
OFF = 0.05  # relative error of shadows of a small lamp: less is not worth a warning
LAMP = 2 * math.pi * (1 - math.cos(RADIUS))  # sr, of the lamps that shadows are measured with


def hardness(radiance: NDArray[np.float32], n: int) -> float:
    """1 for a lamp of `coarseness.RADIUS` alone or less, else less; light (6 n², 3) on a cube map.

    The root of what such a lamp fills of the solid angle that the light fills, (∫ L)² / ∫ L².
    """
    light = radiance.mean(axis=1, dtype=np.float64)
    area = cube_map.solid_angles(n)
    fills = float(light @ area) ** 2 / max(float(light**2 @ area), 1e-30)
    return math.sqrt(min(1.0, LAMP / max(fills, 1e-30)))


class Measured(NamedTuple):
    """Relative errors.

    left     part of all light that passes which were not made would bring
    between  of shadows between vertices, see `coarseness.between_vertices`
    simpler  of shadows of a simpler model, see `coarseness.of_simpler`; 0 where there is none
    """

    left: float
    between: float
    simpler: float


def left_out(scene: Scene) -> Iterator[Diagnosis]:
    """What all frames of a scene come with."""
    if any(light.enabled for light in scene.lights):
        shares = light_shares(scene)
        lamps = shares.lamps + shares.bounced
        if lamps > OFF:
            yield Diagnosis(
                "lights_left_out",
                "This method carries light from the environment alone: the scene's lamps are left "
                f"out, {min(1, lamps):.0%} of the light in the scene as it stands. "
                "direct_to_indirect carries them, for a camera that stands still.",
                min(1.0, lamps),
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


def said_of(measured: Measured, hard: float) -> Iterator[Diagnosis]:
    """What frames come with under an environment so `hard`: see `hardness`.

    Shadows of a light that is larger than the lamps that errors were measured with are off by less:
    errors of its parts do not know of each other.
    """
    left, between, simpler = measured.left, hard * measured.between, hard * measured.simpler
    if left >= LEFT:
        yield Diagnosis(
            "bounces_truncated",
            f"Light that bounces more often than it was followed would add {100 * left:.0f} % or "
            "more to what there is: set bounces higher.",
            left / (1 + left),
        )
    if between >= OFF:
        yield Diagnosis(
            "mesh_too_coarse",
            f"Between the vertices of the mesh light like this is some {100 * between:.0f} % off, "
            "by what was measured at some of them: shadows are as sharp as triangles are small. "
            "Cut the mesh more finely; rectangles have `segments`.",
            between,
        )
    if simpler >= OFF:
        yield Diagnosis(
            "occluders_too_simple",
            f"Shadows are those of a simpler model: light like this is some {100 * simpler:.0f} % "
            "off at the vertices, by what was measured at some of them. Set occluder_vertices "
            "higher, or to 0 for the scene itself.",
            simpler,
        )
