"""A scene for Mitsuba 3, written from the arrays that our own renderers read.

Mitsuba is the rival that renders every picture anew, and an independent referee of our own path
tracer. `differences` tells what it defines otherwise than we do; where that list is empty the two
render the same picture.

Everything here works with whatever variant of Mitsuba is set.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from numpy.typing import NDArray

from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.cook_torrance import MIN_SLOPE, CookTorrance
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.brdf.half_angle_curve import HalfAngleCurve
from engine.brdf.lafortune import Lafortune
from engine.errors import InputError
from engine.light.area import AreaLight
from engine.light.base import Light
from engine.light.disk import DiskLight
from engine.light.distant import DistantLight
from engine.light.environment import Environment
from engine.light.point import PointLight
from engine.light.projector import ProjectorLight
from engine.light.sphere import SphereLight
from engine.light.spot import SpotLight
from engine.scene.description import TEXTURE_SLOTS
from engine.scene.scene import Scene
from engine.scene.surface import NORMAL_MAP

Node = dict[str, Any]
"""What `mitsuba.load_dict` takes."""

WIDE = 0.4  # GGX's α from which a cosine lobe counts as matt, since facets would lose its light
CUTS = 4  # of a pixel of an environment map, along both sides
DIELECTRIC = 0.2  # reflectance at normal incidence up to which a gloss counts as a clear coat


def mitsuba_scene(
    scene: Scene, folder: Path, lamp_albedo: tuple[float, float, float] = (0, 0, 0)
) -> Any:
    """The scene as Mitsuba's own, with its path integrator; its meshes are written to `folder`.

    Mitsuba's lamps are solid: they get the albedo `lamp_albedo` of what is behind them.
    """
    document: Node = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": -1},
        "sensor": _sensor(scene),
    }
    for index, material in enumerate(scene.materials):
        path = folder / f"{index}.ply"
        if not _write_ply(path, scene, index):
            continue
        mesh = {"type": "ply", "filename": str(path), "bsdf": _bsdf(scene, index, material)}
        if any(material.emission):
            mesh["emitter"] = {"type": "area", "radiance": _rgb(material.emission)}
        document[f"mesh{index}"] = mesh
    for index, light in enumerate(scene.lights):
        if light.enabled:
            document[f"light{index}"] = _emitter(light, lamp_albedo)
    if scene.environment is not None:
        document["environment"] = _environment(scene.environment)
    return mi.load_dict(document)


def differences(scene: Scene) -> list[str]:
    """What Mitsuba's picture of a scene has otherwise than ours, noise aside; empty for nothing."""
    found = []
    for name, material in zip(scene.material_names, scene.materials, strict=True):
        white_metal = isinstance(material, Ggx) and (material.diffuse, material.specular) == (
            (0, 0, 0),
            (1, 1, 1),
        )
        if not isinstance(material, Diffuse) and not white_metal:
            found.append(f"{name!r} has another Fresnel term, or another lobe of the same width")
    for light in scene.lights:
        if light.enabled and isinstance(light, SpotLight) and light.penumbra_degrees > 0:
            found.append(f"the spot {light.id!r} falls off otherwise in its penumbra")
        if light.enabled and light.has_extent:
            found.append(f"the lamp {light.id!r} is solid")
    return found


def _rgb(values: Any) -> Node:
    return {"type": "rgb", "value": [float(v) for v in values]}


def _sensor(scene: Scene) -> Node:
    camera = scene.camera
    return {
        "type": "perspective",
        "fov_axis": "y",
        "fov": camera.fov_y_degrees,
        "to_world": _look_at(camera.position, camera.target, camera.up),
        "film": {
            "type": "hdrfilm",
            "width": camera.width,
            "height": camera.height,
            "rfilter": {"type": "box"},
            "pixel_format": "rgb",
            "component_format": "float32",
        },
    }


def _look_at(origin: Any, target: Any, up: Any) -> Any:
    return mi.ScalarTransform4f().look_at(origin=list(origin), target=list(target), up=list(up))


def _write_ply(path: Path, scene: Scene, material: int) -> bool:
    """The triangles of one material with shading normals; False where there are none."""
    geometry = scene.geometry
    triangles = geometry.triangles[geometry.material == material]
    if not len(triangles):
        return False
    used, indices = np.unique(triangles, return_inverse=True)
    fields = ["x", "y", "z", "nx", "ny", "nz", "u", "v"]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(used)}"]
    head += [f"property float {name}" for name in fields]
    head += [f"element face {len(triangles)}", "property list uchar int vertex_indices"]
    faces = np.zeros(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, indices.reshape(-1, 3)
    rows = np.hstack([geometry.positions[used], geometry.normals[used], geometry.uvs[used]])
    text = "\n".join([*head, "end_header", ""]).encode()
    path.write_bytes(text + rows.astype("<f4").tobytes() + faces.tobytes())
    return True


def _bsdf(scene: Scene, index: int, material: Material) -> Node:
    """Diffuse and white metal are ours exactly; gloss is facets of the same width over the base."""
    row = material.row()
    facets = "beckmann" if isinstance(material, CookTorrance) else "ggx"
    base = _texture(scene, index, row[:3])
    specular = row[3:6]
    if isinstance(material, Diffuse) or not specular.any():
        inner: Node = {"type": "diffuse", "reflectance": base}
    elif not isinstance(material, Ggx | CookTorrance) and _alpha(material) > WIDE:
        inner = {"type": "diffuse", "reflectance": _texture(scene, index, row[:3], specular)}
    elif specular.max() > DIELECTRIC:
        # Like a metal; a base below it is lost.
        inner = {
            "type": "roughconductor",
            "material": "none",
            "distribution": facets,
            "alpha": _alpha(material),
            "specular_reflectance": _rgb(specular),
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
    if isinstance(material, AshikhminShirley):
        exponent = math.sqrt((material.exponent_u + 1) * (material.exponent_v + 1)) - 1
    elif isinstance(material, BlinnPhong | HalfAngleCurve):
        exponent = material.exponent
    else:
        # The lobe of a mirror direction is four times as sharp as that of a half vector.
        mirrored = _sharpest(material) if isinstance(material, Lafortune) else material.exponent
        exponent = 4 * mirrored
    return float(np.sqrt(2 / (exponent + 2)))


def _sharpest(material: Lafortune) -> float:
    """Exponent of the lobe that is a highlight, its channels' mean."""
    return max(sum(lobe.exponent) / 3 for lobe in material.lobes)


def _texture(
    scene: Scene, index: int, constant: NDArray[np.float32], more: NDArray[np.float32] | float = 0.0
) -> Node:
    """The diffuse reflectance of a material, a colour or an image times that colour, and more."""
    table = scene.material_table
    q = table.maps[index, TEXTURE_SLOTS.index("diffuse")]
    if q < 0:
        return _rgb(constant + more)
    image = _image(scene, q) * constant + more
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


def _emitter(light: Light, lamp_albedo: Any) -> Node:
    if isinstance(light, PointLight):
        return {
            "type": "point",
            "position": list(light.position),
            "intensity": _rgb(light.intensity),
        }
    if isinstance(light, DistantLight):
        return {
            "type": "directional",
            "direction": list(light.direction),
            "irradiance": _rgb(light.intensity),
        }
    if isinstance(light, SpotLight):
        inner = max(light.cone_degrees - light.penumbra_degrees, 0.0)
        return {
            "type": "spot",
            "to_world": _look_at(light.position, light.target, (0.1, 0.2, 1)),
            "intensity": _rgb(light.intensity),
            "cutoff_angle": light.cone_degrees,
            "beam_width": min(inner, light.cone_degrees * (1 - 1e-5)),
        }
    if isinstance(light, ProjectorLight):
        return _projector(light)
    lamp = {
        "emitter": {"type": "area", "radiance": _rgb(light.intensity)},
        "bsdf": {"type": "diffuse", "reflectance": _rgb(lamp_albedo)},
    }
    if isinstance(light, SphereLight):
        centre = list(light.position)
        return {"type": "sphere", "center": centre, "radius": light.radius, **lamp}
    scale = mi.ScalarTransform4f().scale
    if isinstance(light, DiskLight):
        look = _look_at(light.position, light.target, (0.1, 1, 0.2))
        return {"type": "disk", "to_world": look @ scale([light.radius] * 3), **lamp}
    if not isinstance(light, AreaLight):
        raise InputError(f"Mitsuba has no light like {light.id!r}", field="lights")
    look = _look_at(light.position, light.target, light.up)
    size = [light.width / 2, light.height / 2, 1]
    return {"type": "rectangle", "to_world": look @ scale(size), **lamp}


def _environment(environment: Environment) -> Node:
    """A latitude-longitude map, whose left edge Mitsuba puts along -z and not its middle.

    Mitsuba goes linearly from pixel to pixel: ours are cut, so that only their rims are blurred.
    """
    if environment.description.area_light or not environment.description.background:
        raise InputError("Mitsuba gets no area lights in it, and shows it", field="environment")
    radiance = environment.table.radiance
    if radiance.shape[:2] == (1, 1):
        return {"type": "constant", "radiance": _rgb(radiance[0, 0])}
    image = radiance.repeat(CUTS, axis=0).repeat(CUTS, axis=1)
    image = np.roll(image, image.shape[1] // 2, axis=1)
    turn = mi.ScalarTransform4f().rotate([0, 1, 0], environment.description.rotation_degrees)
    return {
        "type": "envmap",
        "bitmap": mi.Bitmap(np.ascontiguousarray(image, np.float32)),
        "to_world": turn,
    }


def _projector(light: ProjectorLight) -> Node:
    image = light.pyramid()
    texels = image.texels[: image.width * image.height] * np.asarray(light.intensity, np.float32)
    return {
        "type": "projector",
        "to_world": _look_at(light.position, light.target, light.up),
        "fov": light.fov_y_degrees,
        "fov_axis": "y",
        "scale": 1 / np.pi,
        "irradiance": {
            "type": "bitmap",
            "bitmap": mi.Bitmap(texels.reshape(image.height, image.width, 3)),
            "raw": True,
            "wrap_mode": "clamp",
        },
    }
