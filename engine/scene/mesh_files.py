"""Read a mesh file (OBJ, PLY, STL, glTF, GLB): parts, materials, lights, a camera.

trimesh reads the files. What it leaves out of the model is added here: files named with
backslashes or in another folder, colours without rounding to bytes, lights and cameras of glTF.
"""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.diagnosis import Diagnosis
from engine.errors import SceneError
from engine.light.base import Light
from engine.scene import gltf, mtl
from engine.scene.camera import Camera
from engine.scene.companions import Companions
from engine.scene.obj import absolute_indices
from engine.scene.part import Part
from engine.scene.surfaces import Surface

FORMATS = ("obj", "ply", "stl", "gltf", "glb")


@dataclass(frozen=True)
class Node:
    """A part of a file in its place; `matrix` (4, 4) leads to the file's world."""

    name: str
    part: Part
    matrix: NDArray[np.float64]


@dataclass(frozen=True)
class MeshFile:
    """All that a mesh file holds."""

    nodes: tuple[Node, ...]
    surfaces: dict[str, Surface]
    lights: tuple[Light, ...] = ()
    camera: Camera | None = None
    diagnoses: tuple[Diagnosis, ...] = ()


def read_mesh_file(path: Path) -> MeshFile:
    """Read a mesh file. Raises SceneError, which names the file and the object."""
    kind = path.suffix.lower().lstrip(".")
    if kind not in FORMATS:
        raise SceneError(
            f"{path.suffix or 'a file without suffix'} is not a mesh format; "
            f"known: {', '.join(FORMATS)}",
            file=path.name,
        )
    companions = Companions(path.parent)
    try:
        content = path.read_bytes()
    except OSError as error:
        raise SceneError(f"cannot be read: {error.strerror}", file=str(path)) from None
    import trimesh  # a tenth of the time that a start takes, and built-in scenes need none

    header = gltf.header(content, path.name) if kind in ("gltf", "glb") else {}
    if kind == "obj":
        content = absolute_indices(content)
    scene = _trimesh_scene(content, kind, companions, path.name)
    converter = gltf.Converter(header, path.name) if header else mtl.Converter(companions)
    surfaces: dict[str, Surface] = {}
    names: dict[int, str] = {}
    parts: dict[str, Part] = {}
    nodes = []
    for node in scene.graph.nodes_geometry:
        matrix, key = scene.graph[node]
        mesh = scene.geometry[key]
        if not isinstance(mesh, trimesh.Trimesh):
            continue  # points and lines have no surface
        if key not in parts:
            parts[key] = _part(mesh, key, path.name, names, surfaces, converter.surface)
        name = key if list(scene.graph.geometry_nodes[key]) == [node] else f"{key} {node}"
        nodes.append(Node(name, parts[key], np.array(matrix, np.float64)))
    if not nodes:
        raise SceneError("the file holds no triangles", file=path.name)
    try:
        lights, camera = gltf.lights(header), gltf.camera(header)
    except (KeyError, IndexError, TypeError, ValueError) as error:
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise SceneError(
            f"its lights or its camera are broken ({reason})", file=path.name
        ) from None
    diagnoses = (*converter.diagnoses(), *companions.diagnoses(path.name))
    return MeshFile(tuple(nodes), surfaces, lights, camera, diagnoses)


def _trimesh_scene(content: bytes, kind: str, companions: Companions, name: str) -> Any:
    import trimesh

    log = logging.getLogger("trimesh")
    level = log.level
    log.setLevel(logging.CRITICAL)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return trimesh.load_scene(
                trimesh.util.wrap_as_stream(content),
                file_type=kind,
                resolver=companions,
                process=False,
            )
    except IndexError:
        reason = "a face refers to a vertex that the file does not have"
        if kind != "obj":
            reason = f"cannot be read as {kind.upper()}: it is cut short or its indices are wrong"
        raise SceneError(reason, file=name) from None
    except Exception as error:  # trimesh raises whatever its parsers run into
        reason = str(error) or type(error).__name__
        raise SceneError(f"cannot be read as {kind.upper()}: {reason}", file=name) from None
    finally:
        log.setLevel(level)


def _part(
    mesh: Any,
    name: str,
    file: str,
    names: dict[int, str],
    surfaces: dict[str, Surface],
    to_surface: Callable[..., Surface],
) -> Part:
    material = getattr(mesh.visual, "material", None)
    if material is not None and id(material) not in names and _says_something(material):
        names[id(material)] = unique(material.name or "material", surfaces)
        surfaces[names[id(material)]] = to_surface(material)
    uvs = getattr(mesh.visual, "uv", None)
    # trimesh makes normals up on demand; only its cache tells whether the file had some.
    normals = mesh.vertex_normals if "vertex_normals" in mesh._cache else None
    part = Part(
        np.array(mesh.vertices, np.float64),
        np.array(mesh.faces, np.int64).reshape(-1, 3),
        None if normals is None else np.array(normals, np.float64),
        None if uvs is None or len(uvs) != len(mesh.vertices) else np.array(uvs, np.float64),
        names.get(id(material)),
    )
    count = len(part.positions)
    if len(part.triangles) and not 0 <= part.triangles.min() <= part.triangles.max() < count:
        raise SceneError(
            f"object {name!r} refers to vertex {part.triangles.max()} but has only {count}",
            file=file,
        )
    if not np.isfinite(part.positions).all():
        bad = int(np.argmin(np.isfinite(part.positions).all(axis=1)))
        raise SceneError(
            f"vertex {bad} of object {name!r} is {tuple(map(float, part.positions[bad]))}, "
            "not a finite place",
            file=file,
        )
    return part


def _says_something(material: Any) -> bool:
    """Whether it is more than the empty material that stands in for none."""
    import trimesh

    if isinstance(material, trimesh.visual.material.PBRMaterial):
        return True
    return bool(material.kwargs) or bool(mtl.named_image(material))


def unique(name: str, taken: Any) -> str:
    """The name, numbered where it is taken."""
    result, k = name, 2
    while result in taken:
        result, k = f"{name} {k}", k + 1
    return result
