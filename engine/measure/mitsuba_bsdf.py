"""A material for Mitsuba 3: its own plugin where there is one, else the nearest.

Lobes become facets of the same width, isotropic ones, and what was measured is matt, since Mitsuba
has no table of such values. `mitsuba_scene.differences` tells of it.
"""

from __future__ import annotations

import math
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from engine.brdf.albedo import hemispherical_albedo
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import EXTRA, Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.cook_torrance import MIN_SLOPE, CookTorrance
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.brdf.half_angle_curve import HalfAngleCurve
from engine.brdf.lafortune import Lafortune
from engine.brdf.measured import Measured
from engine.brdf.poulin_fournier import PoulinFournier
from engine.brdf.table import INDEX
from engine.brdf.ward import MIN_ALPHA, Ward
from engine.scene.description import TEXTURE_SLOTS
from engine.scene.scene import Scene
from engine.scene.surface import NORMAL_MAP

Node = dict[str, Any]
"""What `mitsuba.load_dict` takes."""

WIDE = 0.4  # GGX's α from which a cosine lobe counts as matt, since facets would lose its light
DIELECTRIC = 0.2  # reflectance at normal incidence up to which a gloss counts as a clear coat


def rgb(values: Any) -> Node:
    """A colour."""
    return {"type": "rgb", "value": [float(v) for v in values]}


def mitsuba_bsdf(scene: Scene, index: int, material: Material) -> Node:
    """Diffuse and white metal are ours exactly; gloss is facets of the same width over the base."""
    row = material.row()
    facets = "beckmann" if isinstance(material, CookTorrance | Ward) else "ggx"
    base = _texture(scene, index, row[:3])
    specular = row[3:6]
    if isinstance(material, Measured):
        # Under even light as bright as ours.
        reflected = hemispherical_albedo(INDEX[Measured], row)[0].astype(np.float32)
        inner: Node = {
            "type": "diffuse",
            "reflectance": _texture(scene, index, reflected, slot="specular"),
        }
    elif isinstance(material, Diffuse) or not specular.any():
        inner = {"type": "diffuse", "reflectance": base}
    elif not isinstance(material, Ggx | CookTorrance) and _alpha(material) > WIDE:
        inner = {"type": "diffuse", "reflectance": _texture(scene, index, row[:3], specular)}
    elif specular.max() > DIELECTRIC:
        # Like a metal; a base below it is lost.
        inner = {
            "type": "roughconductor",
            "material": "none",
            "distribution": facets,
            "alpha": _alpha(material),
            "specular_reflectance": rgb(specular),
        }
    else:
        root = float(np.sqrt(specular.mean()))
        inner = {
            "type": "roughplastic",
            "distribution": facets,
            "alpha": _alpha(material),
            "int_ior": (1 + root) / (1 - root),
            "diffuse_reflectance": base,
        }
    q = scene.material_table.maps[index, NORMAL_MAP]
    if q >= 0:
        bumps = {"type": "bitmap", "bitmap": mi.Bitmap(_image(scene, q)), "raw": True}
        # As light meets the bent normal and nothing else.
        plain = {"use_shadowing_function": False, "flip_invalid_normals": False}
        inner = {"type": "normalmap", "normalmap": bumps, "bsdf": inner, **plain}
    return {"type": "twosided", "bsdf": inner}


def _alpha(material: Any) -> float:
    """α of the facets; GGX's of a cosine power by Walter et al. 2007, §5.2."""
    if isinstance(material, Ggx):
        return float(max(material.roughness**2, 0.002))
    if isinstance(material, CookTorrance):
        return float(max(material.roughness, MIN_SLOPE))
    if isinstance(material, Ward):
        widths = max(material.roughness, MIN_ALPHA), max(material.roughness_v, MIN_ALPHA)
        return math.sqrt(widths[0] * widths[1])
    if isinstance(material, PoulinFournier):
        return _of_cylinders(material)
    if isinstance(material, AshikhminShirley):
        exponent = math.sqrt((material.exponent_u + 1) * (material.exponent_v + 1)) - 1
    elif isinstance(material, BlinnPhong | HalfAngleCurve):
        exponent = material.exponent
    else:
        # The lobe of a mirror direction is four times as sharp as that of a half vector.
        mirrored = _sharpest(material) if isinstance(material, Lafortune) else material.exponent
        exponent = 4 * mirrored
    return float(np.sqrt(2 / (exponent + 2)))


def _of_cylinders(material: PoulinFournier) -> float:
    """Between that along the cylinders, a facet's, and that across, with the lean of the facets."""
    along = 2 / (material.exponent + 2)
    edge, floor = (float(x) for x in material.row()[EXTRA : EXTRA + 2])
    # Lean θ over the width of the surface: ∫ θ² cos θ dθ of the cylinder, and none of the floor.
    edge = abs(edge)
    lean = 2 * ((edge**2 - 2) * math.sin(edge) + 2 * edge * math.cos(edge))
    across = along + 2 * lean / (floor + 2 * math.sin(edge))
    return float((along * across) ** 0.25)


def _sharpest(material: Lafortune) -> float:
    """Exponent of the lobe that is a highlight, its channels' mean."""
    return max(sum(lobe.exponent) / 3 for lobe in material.lobes)


def _texture(
    scene: Scene,
    index: int,
    constant: NDArray[np.float32],
    more: NDArray[np.float32] | float = 0.0,
    slot: str = "diffuse",
) -> Node:
    """A reflectance of a material, a colour or an image times that colour, and more."""
    table = scene.material_table
    q = table.maps[index, TEXTURE_SLOTS.index(slot)]
    # Mitsuba takes no reflectance above 1.
    if q < 0:
        return rgb(np.minimum(1, constant + more))
    image = np.minimum(1, _image(scene, q) * constant + more)
    return {
        "type": "bitmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(image, np.float32)),
        "raw": True,
    }


def _image(scene: Scene, q: int) -> NDArray[np.float32]:
    """Texture q as (height, width, 3)."""
    first, width, height = scene.material_table.texture[q]
    texels = scene.material_table.texels[first : first + width * height]
    return np.ascontiguousarray(texels.reshape(height, width, 3), np.float32)
