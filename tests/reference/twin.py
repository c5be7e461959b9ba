"""The same scene for Mitsuba 3, written from the arrays that our own renderer reads."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np

from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.light.area import AreaLight
from engine.light.disk import DiskLight
from engine.light.point import PointLight
from engine.light.projector import ProjectorLight
from engine.light.sphere import SphereLight
from engine.light.spot import SpotLight
from engine.scene.scene import Scene

mi.set_variant("scalar_rgb")  # the one that needs no LLVM


def rgb(values: Any) -> dict[str, Any]:
    return {"type": "rgb", "value": [float(v) for v in values]}


def write_ply(path: Path, scene: Scene, material: int) -> None:
    """The triangles of one material, with shading normals."""
    triangles = scene.geometry.triangles[scene.geometry.material == material]
    used, indices = np.unique(triangles, return_inverse=True)
    fields = ["x", "y", "z", "nx", "ny", "nz"]
    head = ["ply", "format binary_little_endian 1.0", f"element vertex {len(used)}"]
    head += [f"property float {name}" for name in fields]
    head += [f"element face {len(triangles)}", "property list uchar int vertex_indices"]
    faces = np.zeros(len(triangles), [("count", "u1"), ("corners", "<i4", 3)])
    faces["count"], faces["corners"] = 3, indices.reshape(-1, 3)
    rows = np.hstack([scene.geometry.positions[used], scene.geometry.normals[used]])
    text = "\n".join([*head, "end_header", ""]).encode()
    path.write_bytes(text + rows.astype("<f4").tobytes() + faces.tobytes())


def bsdf(material: Any) -> dict[str, Any]:
    """Only what both renderers define alike: see `test_against_mitsuba`."""
    if isinstance(material, Diffuse):
        inner = {"type": "diffuse", "reflectance": rgb(material.diffuse)}
    else:
        assert isinstance(material, Ggx)
        assert material.diffuse == (0, 0, 0)
        assert material.specular == (1, 1, 1), "Fresnel's formula and Schlick's agree at F0 = 1"
        inner = {
            "type": "roughconductor",
            "material": "none",
            "distribution": "ggx",
            "alpha": material.roughness**2,
        }
    return {"type": "twosided", "bsdf": inner}


def emitter(light: Any, lamp_albedo: Any) -> dict[str, Any]:
    """A light; Mitsuba's area lights are solid, so they get the albedo of what is behind them."""
    to = mi.ScalarTransform4f
    if isinstance(light, PointLight):
        return {
            "type": "point",
            "position": list(light.position),
            "intensity": rgb(light.intensity),
        }
    if isinstance(light, SpotLight):
        assert light.penumbra_degrees == 0, "the falloffs differ in the penumbra"
        return {
            "type": "spot",
            "to_world": to().look_at(
                origin=list(light.position), target=list(light.target), up=[0.1, 0.2, 1]
            ),
            "intensity": rgb(light.intensity),
            "cutoff_angle": light.cone_degrees,
            "beam_width": light.cone_degrees * (1 - 1e-5),
        }
    if isinstance(light, ProjectorLight):
        image = light.pyramid()
        texels = image.texels[: image.width * image.height] * np.float32(light.intensity)
        return {
            "type": "projector",
            "to_world": to().look_at(
                origin=list(light.position), target=list(light.target), up=list(light.up)
            ),
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
    lamp = {
        "emitter": {"type": "area", "radiance": rgb(light.intensity)},
        "bsdf": {"type": "diffuse", "reflectance": rgb(lamp_albedo)},
    }
    if isinstance(light, SphereLight):
        return {
            "type": "sphere",
            "center": list(light.position),
            "radius": light.radius,
            **lamp,
        }
    up = [0.1, 1, 0.2] if isinstance(light, DiskLight) else list(light.up)
    look = to().look_at(origin=list(light.position), target=list(light.target), up=up)
    if isinstance(light, DiskLight):
        return {"type": "disk", "to_world": look @ to().scale([light.radius] * 3), **lamp}
    assert isinstance(light, AreaLight)
    size = [light.width / 2, light.height / 2, 1]
    return {"type": "rectangle", "to_world": look @ to().scale(size), **lamp}


def twin(scene: Scene, folder: Path, lamp_albedo: Any = (0, 0, 0)) -> Any:
    """The scene as Mitsuba's own, with a path integrator."""
    camera = scene.camera
    document: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": -1},
        "sensor": {
            "type": "perspective",
            "fov_axis": "y",
            "fov": camera.fov_y_degrees,
            "to_world": mi.ScalarTransform4f().look_at(
                origin=list(camera.position), target=list(camera.target), up=list(camera.up)
            ),
            "film": {
                "type": "hdrfilm",
                "width": camera.width,
                "height": camera.height,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
                "component_format": "float32",
            },
        },
    }
    for index, material in enumerate(scene.materials):
        path = folder / f"{index}.ply"
        write_ply(path, scene, index)
        document[f"mesh{index}"] = {"type": "ply", "filename": str(path), "bsdf": bsdf(material)}
    for index, light in enumerate(scene.lights):
        document[f"light{index}"] = emitter(light, lamp_albedo)
    if scene.environment is not None:
        assert scene.environment.radiance.shape[:2] == (1, 1), "ours does not interpolate maps"
        document["environment"] = {
            "type": "constant",
            "radiance": rgb(scene.environment.table.radiance[0, 0]),
        }
    return mi.load_dict(document)


def batches(theirs: Any, samples: int, count: int) -> np.ndarray:
    """(count, h, w, 3) float64: independent pictures of `samples` samples per pixel each."""
    return np.array([mi.render(theirs, spp=samples, seed=1 + k) for k in range(count)], np.float64)
