"""A scene for Mitsuba 3, written from the arrays that our own renderers read.

Mitsuba is the rival that renders every picture anew, and an independent referee of our own path
tracer. `differences` tells what it defines otherwise than we do; where that list is empty the two
render the same picture.

Everything here works with whatever variant of Mitsuba is set.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.brdf.measured import Measured
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
from engine.measure.mitsuba_bsdf import Node, mitsuba_bsdf, rgb
from engine.scene.scene import Scene

CUTS = 4  # of a pixel of an environment map, along both sides


def mitsuba_scene(
    scene: Scene,
    folder: Path,
    max_bounces: int | None = None,
    lamp_albedo: tuple[float, float, float] = (0, 0, 0),
) -> Any:
    """The scene as Mitsuba's own, with its path integrator; its meshes are written to `folder`.

    Light is cut off after `max_bounces`, if there is such a number.

    Mitsuba's lamps are solid: they get the albedo `lamp_albedo` of what is behind them.
    """
    document: Node = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": -1 if max_bounces is None else max_bounces + 1},
        "sensor": _sensor(scene),
    }
    for index, material in enumerate(scene.materials):
        path = folder / f"{index}.ply"
        if not _write_ply(path, scene, index):
            continue
        mesh = {"type": "ply", "filename": str(path), "bsdf": mitsuba_bsdf(scene, index, material)}
        if any(material.emission):
            mesh["emitter"] = {"type": "area", "radiance": rgb(material.emission)}
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
        if isinstance(material, Measured):
            found.append(f"{name!r} was measured and is matt, of the same albedo under even light")
        elif not isinstance(material, Diffuse) and not white_metal:
            found.append(f"{name!r} has another Fresnel term, or another lobe of the same width")
    for light in scene.lights:
        if light.enabled and isinstance(light, SpotLight) and light.penumbra_degrees > 0:
            found.append(f"the spot {light.id!r} falls off otherwise in its penumbra")
        if light.enabled and light.has_extent:
            found.append(f"the lamp {light.id!r} is solid")
    return found


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


def _emitter(light: Light, lamp_albedo: Any) -> Node:
    if isinstance(light, PointLight):
        return {
            "type": "point",
            "position": list(light.position),
            "intensity": rgb(light.intensity),
        }
    if isinstance(light, DistantLight):
        return {
            "type": "directional",
            "direction": list(light.direction),
            "irradiance": rgb(light.intensity),
        }
    if isinstance(light, SpotLight):
        inner = max(light.cone_degrees - light.penumbra_degrees, 0.0)
        return {
            "type": "spot",
            "to_world": _look_at(light.position, light.target, (0.1, 0.2, 1)),
            "intensity": rgb(light.intensity),
            "cutoff_angle": light.cone_degrees,
            "beam_width": min(inner, light.cone_degrees * (1 - 1e-5)),
        }
    if isinstance(light, ProjectorLight):
        return _projector(light)
    lamp = {
        "emitter": {"type": "area", "radiance": rgb(light.intensity)},
        "bsdf": {"type": "diffuse", "reflectance": rgb(lamp_albedo)},
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
        return {"type": "constant", "radiance": rgb(radiance[0, 0])}
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
