"""Build a scene from its description."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from engine.brdf.base import GRAIN, Material
from engine.brdf.diffuse import Diffuse
from engine.diagnosis import Diagnosis
from engine.errors import SceneError
from engine.light.base import Light
from engine.light.maps import load_environment
from engine.scene import framing, lighting, shapes
from engine.scene.albedos import albedo_diagnoses
from engine.scene.camera import Camera
from engine.scene.description import NormalMap, Object, SceneDescription, split
from engine.scene.explain import closest
from engine.scene.geometry import Placed, assemble
from engine.scene.mesh_files import MeshFile, read_mesh_file, unique
from engine.scene.mtl import capped
from engine.scene.rays import RayTracer
from engine.scene.scene import Geometry, MaterialTable, Scene
from engine.scene.surface import NORMAL_MAP
from engine.scene.surfaces import Surface
from engine.scene.tables import material_table
from engine.scene.textures import MAX_SIDE, Image, read_image, steeper


class _Builder:
    """What a scene is made of, as it grows."""

    def __init__(self) -> None:
        self.surfaces: dict[str, Surface] = {}
        self.placed: list[Placed] = []
        self.objects: list[str] = []
        self.diagnoses: list[Diagnosis] = []
        self.lights: list[Light] = []
        self.camera: Camera | None = None
        self.folder = Path()
        self._files: dict[Path, tuple[MeshFile, dict[str, int]]] = {}

    def grey(self) -> int:
        """The index of the material of things that have none."""
        self.surfaces.setdefault("grey", Surface(Diffuse(emission=(0.0, 0.0, 0.0))))
        return list(self.surfaces).index("grey")

    def file(self, path: Path) -> tuple[MeshFile, dict[str, int]]:
        """A mesh file and the indices of its materials; it is read once."""
        if path not in self._files:
            read = read_mesh_file(path)
            places = {}
            for name, surface in read.surfaces.items():
                places[name] = len(self.surfaces)
                self.surfaces[unique(name, self.surfaces)] = surface
            self.diagnoses += read.diagnoses
            self.lights += read.lights
            self.camera = self.camera or read.camera
            self._files[path] = read, places
        return self._files[path]

    def finish(
        self, name: str, camera: Camera | None, lights: Sequence[Light] | None
    ) -> tuple[Scene, RayTracer]:
        """The scene without its environment."""
        geometry, mended = assemble(self.placed, self.objects)
        rays = RayTracer(geometry.positions, geometry.triangles)
        materials = tuple(surface.material for surface in self.surfaces.values())
        table = material_table(materials, [surface.images for surface in self.surfaces.values()])
        names = tuple(self.surfaces)
        return Scene(
            name=name,
            camera=camera or framing.default_camera(geometry, rays),
            geometry=geometry,
            material_table=table,
            material_names=names,
            materials=materials,
            object_names=tuple(self.objects),
            lights=tuple(lights or ()),
            environment=None,
            folder=str(self.folder.resolve()),
            diagnoses=(
                *self.diagnoses,
                *mended,
                *_without_coordinates(geometry, table, names),
                *albedo_diagnoses(names, materials, table),
            ),
        ), rays


def build(description: SceneDescription, folder: Path, file: str = "") -> Scene:
    """Read what the description names, relative to `folder`, and lay it out flat."""
    made = _Builder()
    images: dict[tuple[Path, bool], Image] = {}
    for name, material in description.materials.items():
        constants, textures = split(material)
        slots = {}
        for slot, texture in textures.items():
            place = f"materials.{name}.{slot}"
            slots[slot] = _texture(folder, texture.texture, place, images, made.diagnoses)
            if isinstance(texture, NormalMap):
                slots[slot] = steeper(slots[slot], texture.strength)
        made.surfaces[name] = Surface(_located(constants, folder, name), slots)
    for index, thing in enumerate(description.objects):
        _add_object(made, thing, index, folder, list(description.materials))
    lights = _checked(description.lights, folder)
    made.folder = folder
    scene, rays = made.finish(description.name, description.camera, lights)
    if description.environment is not None:
        environment = load_environment(description.environment, folder)
        scene = replace(scene, environment=environment)
    if lights is None and description.environment is None:
        scene = _lit(scene, rays, made.lights)
    scene.__dict__["rays"] = rays
    return scene


def build_from_mesh(path: Path) -> Scene:
    """A scene of a mesh file alone."""
    made = _Builder()
    made.folder = path.parent
    read, places = made.file(path)
    for node in read.nodes:
        material = made.grey() if node.part.material is None else places[node.part.material]
        made.placed.append(Placed(node.part, node.matrix, material, len(made.objects)))
        made.objects.append(unique(node.name, made.objects))
    try:
        scene, rays = made.finish(path.stem, made.camera, None)
    except SceneError as error:
        raise SceneError(error.message, field=error.field, file=path.name) from None
    scene = _lit(scene, rays, made.lights)
    scene.__dict__["rays"] = rays
    return scene


def _lit(scene: Scene, rays: RayTracer, own: Sequence[Light]) -> Scene:
    """The scene under the lights of its file, or under default ones where it has none."""
    if own:
        return replace(scene, lights=tuple(own))
    note = "besides the surfaces that shine, " if scene.material_table.emission.any() else ""
    lights = lighting.default_lights(scene.geometry, rays, scene.camera)
    names = ", ".join(light.id for light in lights)
    diagnosis = Diagnosis("default_lights", f"the scene has no lights: {note}{names} were added")
    return replace(scene, lights=lights, diagnoses=(*scene.diagnoses, diagnosis))


def _add_object(
    made: _Builder, thing: Object, index: int, folder: Path, known: Sequence[str]
) -> None:
    field = f"objects.{index}"
    if thing.material is not None and thing.material not in known:
        raise SceneError(
            f"there is no material {thing.material!r}; {closest(thing.material, known)}",
            field=f"{field}.material",
        )
    if thing.name in made.objects:
        raise SceneError(f"another object is named {thing.name!r} too", field=f"{field}.name")
    made.objects.append(thing.name)
    own: int | None = None if thing.material is None else list(made.surfaces).index(thing.material)
    if not isinstance(thing.mesh, str):
        material = made.grey() if own is None else own
        made.placed.append(Placed(shapes.make(thing.mesh), thing.matrix(), material, index))
        return
    path = folder / thing.mesh
    if not path.is_file():
        raise SceneError("there is no such file", field=f"{field}.mesh", file=str(path))
    read, places = made.file(path.resolve())
    for node in read.nodes:
        name = node.part.material
        if own is not None:
            material = own
        elif name is None:
            material = made.grey()
        else:
            material = places[name]
        made.placed.append(Placed(node.part, thing.matrix() @ node.matrix, material, index))


def _located(material: Material, folder: Path, name: str) -> Material:
    try:
        return material.located(folder)
    except SceneError as error:
        field = f"materials.{name}.{error.field}"
        raise SceneError(error.message, field=field, file=error.file) from None


def _texture(
    folder: Path,
    name: str,
    field: str,
    images: dict[tuple[Path, bool], Image],
    diagnoses: list[Diagnosis],
) -> Image:
    path, srgb = folder / name, not field.endswith((".roughness", ".normal"))
    if not path.is_file():
        raise SceneError("there is no such file", field=f"{field}.texture", file=str(path))
    if (path, srgb) not in images:
        images[path, srgb], side = read_image(path, name, srgb=srgb)
        if side > MAX_SIDE:
            diagnoses.append(capped(name, side))
    return images[path, srgb]


def _checked(lights: Sequence[Light] | None, folder: Path) -> tuple[Light, ...] | None:
    """The lights, each of another id, with the files that they name read."""
    if lights is None:
        return None
    seen: set[str] = set()
    located = []
    for index, light in enumerate(lights):
        if light.id in seen:
            raise SceneError(f"another light has the id {light.id!r}", field=f"lights.{index}.id")
        seen.add(light.id)
        try:
            located.append(light.located(folder))
        except SceneError as error:
            field = f"lights.{index}.{error.field}"
            raise SceneError(error.message, field=field, file=error.file) from None
    return tuple(located)


def _without_coordinates(
    geometry: Geometry, table: MaterialTable, names: Sequence[str]
) -> list[Diagnosis]:
    """What to say of textured or brushed materials on surfaces without texture coordinates."""
    # A vertex may well lie at the origin of the texture, but hardly all of a material's.
    count = np.bincount(geometry.material, minlength=len(names))
    mapped = geometry.material[np.abs(geometry.uvs[geometry.triangles]).max(axis=(1, 2)) > 0]
    bare = (count > 0) & (np.bincount(mapped, minlength=len(names)) == 0)
    textured = table.maps[:, :NORMAL_MAP].max(axis=1) >= 0
    lacking = (
        (textured, "a texture", "one texel colours them all"),
        (~textured & (table.maps[:, NORMAL_MAP] >= 0), "a normal map", "they stay smooth"),
    )
    return [
        Diagnosis(
            "no_texture_coordinates",
            f"material {names[m]!r} has {what} but its surfaces have no texture coordinates: {so}",
        )
        for which, what, so in lacking
        for m in np.flatnonzero(bare & which).tolist()
    ] + [
        Diagnosis(
            "no_tangents",
            f"material {names[m]!r} is brushed along the texture coordinates, but its surfaces "
            "have none: the grain lies as it comes, and may turn where it should run straight",
        )
        for m in np.flatnonzero(bare & table.row[:, GRAIN:].any(axis=1)).tolist()
    ]
