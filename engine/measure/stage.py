"""The scenes of the paper's tables and figures: an object on a finely cut matt floor, or alone.

Wang, Tran, Luebke 2006, *All-Frequency Relighting of Glossy Objects*, §5. Every object is brought
to a largest side of one metre and stands just above the floor, at y = 0; all are seen from the same
place.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.published import PUBLISHED
from engine.light.environment import Environment, EnvironmentDescription
from engine.light.maps import load_environment
from engine.measure.levels import smooth
from engine.scene.camera import Camera
from engine.scene.geometry import Placed, assemble
from engine.scene.mesh_files import read_mesh_file
from engine.scene.part import Part
from engine.scene.scene import Scene
from engine.scene.shapes import Rectangle, Sphere, TorusKnot, make
from engine.scene.tables import material_table

DARK = (0.0, 0.0, 0.0)
MATERIALS: dict[str, Material] = {
    "diffuse": Diffuse(emission=DARK, diffuse=(0.5, 0.5, 0.5)),
    **PUBLISHED,
}
"""What the object is made of: a matt grey, and the materials of §5."""

FLOOR = Diffuse(emission=DARK, diffuse=(0.5, 0.36, 0.26))
FLOOR_SIZE = 4.0
OBJECT, GROUND = 0, 1  # indices of objects and of materials
LIFT = 0.01  # metres between the floor and the object, so that no vertex lies in it
WAY = np.array([0.3, 0.75, 0.78])  # from the object's middle to the camera
DISTANCE, FOV_Y_DEGREES = 3.6, 25.0


@dataclass(frozen=True)
class Thing:
    """An object by its name."""

    name: str
    part: Part


def read_thing(path: str) -> Thing:
    """The triangles of a mesh file as one object, smooth and without its materials.

    Raises SceneError, naming the file, where it cannot be read.
    """
    positions, triangles, uvs, count = [], [], [], 0
    for node in read_mesh_file(Path(path)).nodes:
        part, linear = node.part, node.matrix[:3, :3]
        positions.append(part.positions @ linear.T + node.matrix[:3, 3])
        turned = part.triangles[:, ::-1] if np.linalg.det(linear) < 0 else part.triangles
        triangles.append(turned + count)
        uvs.append(part.uvs)
        count += len(part.positions)
    mapped = [each for each in uvs if each is not None]
    joined = Part(
        np.concatenate(positions),
        np.concatenate(triangles),
        uvs=np.concatenate(mapped) if len(mapped) == len(uvs) else None,
    )
    return Thing(Path(path).stem, smooth(joined))


def knot(segments: int = 320, sides: int = 32) -> Thing:
    """A torus knot of about `segments` times `sides` vertices, standing upright."""
    part = make(TorusKnot(shape="torus_knot", ring=0.21, tube=0.11, segments=segments, sides=sides))
    upright = np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])
    assert part.normals is not None
    turned = Part(part.positions @ upright, part.triangles, part.normals @ upright, part.uvs)
    return Thing("knot", turned)


def ball(rings: int = 64) -> Thing:
    """A ball of about 2 `rings`² vertices, without texture coordinates: they meet at the poles."""
    part = make(Sphere(shape="sphere", rings=rings))
    return Thing("ball", Part(part.positions, part.triangles, part.normals))


def stage(
    thing: Thing,
    material: Material,
    size: tuple[int, int],
    *,
    cuts: int | None,
    environment: Environment | None = None,
    folder: Path = Path(),
) -> Scene:
    """The object of a material, on a floor or alone, under an environment or a white sky.

    size    width and height of the picture
    cuts    of the floor along both sides; None for no floor
    folder  where the environments that edits name are looked for
    """
    part = thing.part
    placed, names = [Placed(part, _standing(part), OBJECT, OBJECT)], ["object"]
    if cuts is not None:
        shape = Rectangle(shape="rectangle", size=(FLOOR_SIZE, FLOOR_SIZE), segments=(cuts, cuts))
        flat = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
        placed.append(Placed(make(shape), flat, GROUND, GROUND))
        names.append("floor")
    geometry, _ = assemble(placed, names)
    materials = (material, FLOOR)[: len(names)]
    return Scene(
        name=thing.name if cuts is None else f"{thing.name} on a floor",
        camera=_camera(geometry.positions[geometry.triangles[geometry.object == OBJECT]], size),
        geometry=geometry,
        material_table=material_table(materials, [{} for _ in names]),
        material_names=tuple(names),
        materials=materials,
        object_names=tuple(names),
        lights=(),
        environment=environment or load_environment(EnvironmentDescription(), Path()),
        folder=str(folder.resolve()),
    )


def _standing(part: Part) -> NDArray[np.float64]:
    """(4, 4): brings the part to its size and to its place above the floor."""
    used = part.positions[part.triangles.ravel()]
    low, high = used.min(axis=0), used.max(axis=0)
    scale = 1.0 / float((high - low).max())
    matrix = np.diag([scale, scale, scale, 1.0])
    middle = (low + high) / 2
    matrix[:3, 3] = -scale * np.array([middle[0], low[1], middle[2]])
    matrix[1, 3] += LIFT
    return matrix


def _camera(corners: NDArray[np.float32], size: tuple[int, int]) -> Camera:
    """Looks down at the middle of the object's corners (t, 3, 3)."""
    target = np.array([0.0, float(corners[..., 1].max()) / 2, 0.0])
    position = target + DISTANCE * WAY / np.linalg.norm(WAY)
    return Camera(
        position=tuple(position.tolist()),
        target=tuple(target.tolist()),
        fov_y_degrees=FOV_Y_DEGREES,
        width=size[0],
        height=size[1],
    )
