"""Read a mesh file (OBJ, PLY, STL, glTF, GLB): parts, materials, lights, a camera.

trimesh reads the files. What it leaves out of the model is added here: files named with
backslashes or in another folder, colours without rounding to bytes, lights and cameras of glTF.
"""

from __future__ import annotations

import contextlib
import logging
import warnings
from collections.abc import Callable, Iterator
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
from engine.scene.promises import check_ply, check_stl
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

    header: dict[str, Any] = {}
    if kind in ("gltf", "glb"):
        header = gltf.header(content, companions, path.name)
        # Whatever its name says: what has been checked is what is read.
        kind = "glb" if content[:4] == gltf.MAGIC else "gltf"
    elif kind == "obj":
        content = absolute_indices(content)
    else:
        {"ply": check_ply, "stl": check_stl}[kind](content, path.name)
    scene = _trimesh_scene(content, kind, companions, path.name)
    with _broken("its materials", path.name):
        converter = gltf.Converter(header, path.name) if header else mtl.Converter(companions)
    surfaces: dict[str, Surface] = {}
    names: dict[int, str] = {}
    parts: dict[str, Part] = {}
    nodes = []
    for node in scene.graph.nodes_geometry:
        with _broken(f"node {node!r:.80}", path.name):
            matrix, key = scene.graph[node]
            mesh = scene.geometry[key]
            if not isinstance(mesh, trimesh.Trimesh) or not np.any(matrix[:3, :3]):
                continue  # points and lines have no surface, a scale of 0 hides what there is
            if key not in parts:
                parts[key] = _part(mesh, key, path.name, names, surfaces, converter.surface)
            name = key if list(scene.graph.geometry_nodes[key]) == [node] else f"{key} {node}"
            nodes.append(Node(name, parts[key], np.array(matrix, np.float64)))
    if not nodes:
        raise SceneError("the file holds no triangles", file=path.name)
    with _broken("its lights or its camera", path.name):
        lights, camera = gltf.lights(header), gltf.camera(header)
    diagnoses = (*converter.diagnoses(), *companions.diagnoses(path.name))
    return MeshFile(tuple(nodes), surfaces, lights, camera, diagnoses)


@contextlib.contextmanager
def _broken(what: str, file: str) -> Iterator[None]:
    """Whatever goes wrong with a part of a file is the file's fault."""
    try:
        yield
    except (SceneError, MemoryError):
        raise
    except Exception as error:  # anything may be of another kind than it should be
        reason = f"{type(error).__name__}: {error}".splitlines()[0]
        raise SceneError(f"{what} cannot be used ({reason:.200})", file=file) from None


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
        if isinstance(error, KeyError):
            reason = f"there is nothing called {reason}"
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
    count = len(mesh.vertices)
    if np.shape(mesh.vertices) != (count, 3):
        raise SceneError(f"vertices of object {name!r} have no three coordinates", file=file)
    uvs = getattr(mesh.visual, "uv", None)
    # trimesh makes normals up on demand; only its cache tells whether the file had some.
    normals = mesh.vertex_normals if "vertex_normals" in mesh._cache else None
    part = Part(
        np.array(mesh.vertices, np.float64),
        np.array(mesh.faces, np.int64).reshape(-1, 3),
        None if normals is None else np.array(normals, np.float64),
        None if uvs is None or np.shape(uvs) != (count, 2) else np.array(uvs, np.float64),
        names.get(id(material)),
    )
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
