"""What a glTF file says: metallic-roughness materials, lights, the camera.

Materials (glTF 2.0 §3.9.2, appendix B): diffuse = base (1 - metallic), reflectance at normal
incidence = 0.04 (1 - metallic) + base · metallic, roughness as it is; texel by texel where there
are textures; normal textures bend the normals. Lights: KHR_lights_punctual; candela and lux are
divided by 683 lm/W, since intensity here is W·sr⁻¹ and W·m⁻² up to a common scale.
"""

from __future__ import annotations

import json
import math
import struct
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from engine.brdf.ggx import Ggx
from engine.diagnosis import Diagnosis
from engine.errors import SceneError
from engine.light.base import Light
from engine.light.distant import DistantLight
from engine.light.point import PointLight
from engine.light.spot import SpotLight
from engine.scene.camera import Camera
from engine.scene.companions import Companions
from engine.scene.gltf_tables import check_tables
from engine.scene.mtl import capped, opaque
from engine.scene.surfaces import Surface
from engine.scene.textures import MAX_SIDE, Image, read_image, resized, steeper

MAGIC = b"glTF"
MAX_STEEPNESS = 10.0  # of a normal map
LUMENS_PER_WATT = 683.0
IGNORED = {
    "KHR_texture_transform": "texture transforms",
    "KHR_materials_transmission": "transmission",
    "KHR_materials_clearcoat": "clear coats",
    "KHR_materials_sheen": "sheen",
    "KHR_materials_anisotropy": "anisotropy",
}


def header(content: bytes, beside: Companions, file: str) -> dict[str, Any]:
    """The JSON of a glTF or GLB file; its tables fit together."""
    binary = None
    try:
        if content[:4] == MAGIC:
            length = struct.unpack_from("<I", content, 12)[0]
            if len(content) >= 28 + length:
                binary = struct.unpack_from("<I", content, 20 + length)[0]
                binary = min(binary, len(content) - 28 - length)
            content = content[20 : 20 + length]
        found = json.loads(content)
    except (ValueError, RecursionError, struct.error) as error:
        raise SceneError(f"cannot be read as glTF: {error}", file=file) from None
    if not isinstance(found, dict) or "asset" not in found:
        raise SceneError("cannot be read as glTF: it has no asset", file=file)
    check_tables(found, binary, beside, file)
    return found


class Converter:
    """Turns the materials of one file into ours; an image used twice is read once."""

    def __init__(self, header: dict[str, Any], file: str) -> None:
        self.file = file
        self._found: list[Diagnosis] = []
        self._transparent: list[str] = []
        self._images: dict[tuple[int, bool], Image] = {}
        named = [m for m in header.get("materials", []) if isinstance(m, dict) and "name" in m]
        names = [m["name"] for m in named]
        self._exact = {m["name"]: m for m in named if names.count(m["name"]) == 1}
        ignored = [IGNORED[name] for name in header.get("extensionsUsed", []) if name in IGNORED]
        if ignored:
            self._found.append(
                Diagnosis("ignored_extension", f"{file} asks for {', '.join(ignored)}: left out")
            )

    def diagnoses(self) -> list[Diagnosis]:
        """What to say of the materials converted so far."""
        return [*self._found, *([opaque(self._transparent)] if self._transparent else [])]

    def surface(self, material: Any) -> Surface:
        """Ours for one of trimesh's `PBRMaterial`."""
        # trimesh rounds factors to bytes, so they are taken from the file where it is clear whose
        # they are.
        exact = self._exact.get(material.name, {})
        factors = exact.get("pbrMetallicRoughness", {}).get("baseColorFactor")
        if factors is None and material.baseColorFactor is not None:
            factors = np.asarray(material.baseColorFactor) / 255.0
        base = np.ones(3) if factors is None else np.clip(_finite(factors[:3]), 0, 1)
        metallic = _unit(material.metallicFactor)
        roughness = _unit(material.roughnessFactor)
        emission = self._emission(material, exact)
        if material.alphaMode not in (None, "OPAQUE"):
            self._transparent.append(material.name or "material")
        colour = self._image(material.baseColorTexture, srgb=True)
        rough = self._image(material.metallicRoughnessTexture, srgb=False)
        images: dict[str, Image] = {}
        if rough is not None:
            images["roughness"] = np.repeat(rough[:, :, 1:2], 3, axis=2)
        if rough is None and (colour is None or metallic == 0):
            # The constants say it all, but for the colour of something that is no metal.
            if colour is not None:
                images["diffuse"] = colour
            diffuse, specular = base * (1 - metallic), 0.04 * (1 - metallic) + base * metallic
        else:
            colours, metals = _same_size(colour, rough)
            metal = metallic * (metals[:, :, 2:3] if rough is not None else 1)
            images["diffuse"] = np.asarray(colours * (1 - metal), np.float32)
            images["specular"] = np.asarray(0.04 * (1 - metal) + base * colours * metal, np.float32)
            diffuse, specular = base, np.ones(3)
        bumps = self._image(material.normalTexture, srgb=False)
        if bumps is not None:
            strength = float(_finite(exact.get("normalTexture", {}).get("scale", 1.0)))
            strength = min(max(strength, -MAX_STEEPNESS), MAX_STEEPNESS)
            images["normal"] = steeper(bumps, strength)
        made = Ggx(
            emission=emission,
            diffuse=tuple(diffuse.tolist()),
            specular=tuple(specular.tolist()),
            roughness=roughness,
        )
        return Surface(made, images)

    def _emission(self, material: Any, exact: dict[str, Any]) -> tuple[float, float, float]:
        factor = material.emissiveFactor
        colour = np.zeros(3) if factor is None else np.clip(np.asarray(factor, float)[:3], 0, None)
        strength = exact.get("extensions", {}).get("KHR_materials_emissive_strength", {})
        colour = colour * float(strength.get("emissiveStrength", 1.0))
        image = self._image(material.emissiveTexture, srgb=True) if colour.any() else None
        if image is not None:
            colour = colour * image.mean(axis=(0, 1))
            self._found.append(
                Diagnosis(
                    "emission_averaged",
                    f"material {material.name!r} emits through a texture: its mean is used",
                )
            )
        return (float(colour[0]), float(colour[1]), float(colour[2]))

    def _image(self, image: Any, *, srgb: bool) -> Image | None:
        if image is None:
            return None
        key = (id(image), srgb)
        if key not in self._images:
            self._images[key], side = read_image(image, self.file, srgb=srgb)
            if side > MAX_SIDE:
                self._found.append(capped(f"a texture of {self.file}", side))
        return self._images[key]


def _unit(value: Any) -> float:
    return 1.0 if value is None else float(np.clip(_finite(value), 0, 1))


def _finite(value: Any) -> NDArray[np.float64]:
    numbers = np.asarray(value, np.float64)
    if not np.isfinite(numbers).all():
        raise ValueError(f"a factor is {value}, not a finite number")
    return numbers


def _same_size(colour: Image | None, rough: Image | None) -> tuple[Image, Image]:
    """Both images at the size of the larger one; white for one that is missing."""
    sizes = [image.shape[:2] for image in (colour, rough) if image is not None]
    height, width = max(size[0] for size in sizes), max(size[1] for size in sizes)

    def fit(image: Image | None) -> Image:
        if image is None:
            return np.ones((height, width, 3), np.float32)
        return image if image.shape[:2] == (height, width) else resized(image, width, height)

    return fit(colour), fit(rough)


def _nodes(header: dict[str, Any]) -> list[tuple[dict[str, Any], NDArray[np.float64]]]:
    """Every node of the scene with its (4, 4) matrix to the world."""
    nodes, scenes = header.get("nodes", []), header.get("scenes", [])
    roots = scenes[header.get("scene", 0)].get("nodes", []) if scenes else range(len(nodes))
    found: list[tuple[dict[str, Any], NDArray[np.float64]]] = []
    todo = [(index, np.eye(4)) for index in roots]
    while todo and len(found) <= len(nodes):
        index, parent = todo.pop(0)
        node = nodes[index]
        matrix = parent @ _local(node)
        found.append((node, matrix))
        todo += [(child, matrix) for child in node.get("children", [])]
    return found


def _local(node: dict[str, Any]) -> NDArray[np.float64]:
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    import trimesh  # late, see `mesh_files`

    x, y, z, w = node.get("rotation", (0, 0, 0, 1))
    matrix: NDArray[np.float64] = trimesh.transformations.quaternion_matrix([w, x, y, z])
    matrix[:3, :3] *= np.asarray(node.get("scale", (1, 1, 1)), float)
    matrix[:3, 3] = node.get("translation", (0, 0, 0))
    return matrix


def lights(header: dict[str, Any]) -> tuple[Light, ...]:
    """The lights of KHR_lights_punctual."""
    known = header.get("extensions", {}).get("KHR_lights_punctual", {}).get("lights", [])
    found: list[Light] = []
    for node, matrix in _nodes(header) if known else []:
        index = node.get("extensions", {}).get("KHR_lights_punctual", {}).get("light")
        if index is None:
            continue
        light = known[index]
        name = str(node.get("name") or light.get("name") or "light")[:48]
        name = name if all(name != other.id for other in found) else f"{name} {len(found) + 1}"
        strength = float(light.get("intensity", 1.0)) / LUMENS_PER_WATT
        intensity = tuple(strength * float(c) for c in light.get("color", (1, 1, 1)))
        place, ahead = matrix[:3, 3], -matrix[:3, 2]
        common: dict[str, Any] = {"id": name, "intensity": intensity}
        if light["type"] == "directional":
            found.append(DistantLight(**common, direction=tuple(ahead.tolist())))
        elif light["type"] == "point":
            found.append(PointLight(**common, position=tuple(place.tolist())))
        else:
            cone = light.get("spot", {})
            outer = math.degrees(cone.get("outerConeAngle", math.pi / 4))
            inner = math.degrees(cone.get("innerConeAngle", 0.0))
            found.append(
                SpotLight(
                    **common,
                    position=tuple(place.tolist()),
                    target=tuple((place + ahead).tolist()),
                    cone_degrees=max(outer, 0.1),
                    penumbra_degrees=max(0.0, outer - inner),
                )
            )
    return tuple(found)


def camera(header: dict[str, Any]) -> Camera | None:
    """The first perspective camera, 480 pixels high."""
    for node, matrix in _nodes(header) if header.get("cameras") else []:
        lens = header["cameras"][node["camera"]].get("perspective") if "camera" in node else None
        if lens:
            aspect = min(max(float(lens.get("aspectRatio", 4 / 3)), 0.1), 10.0)
            try:
                back, up = (matrix[:3, k] / np.linalg.norm(matrix[:3, k]) for k in (2, 1))
                return Camera(
                    position=tuple(matrix[:3, 3].tolist()),
                    target=tuple((matrix[:3, 3] - back).tolist()),
                    up=tuple(up.tolist()),
                    fov_y_degrees=math.degrees(lens["yfov"]),
                    width=round(480 * aspect),
                    height=480,
                )
            except ValidationError:
                return None  # a lens that is no lens: the default camera will do
    return None
