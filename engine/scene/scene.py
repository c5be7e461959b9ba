"""The scene as the engine computes with it: flat arrays in world space."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import Material
from engine.diagnosis import Diagnosis
from engine.light.base import Light
from engine.light.environment import Environment
from engine.scene.camera import Camera
from engine.scene.rays import RayTracer


class Geometry(NamedTuple):
    """All triangles of all objects, in world space; a kernel argument as it is.

    positions  (v, 3) float32   metres
    triangles  (t, 3) int32     counter-clockwise seen from outside
    normals    (v, 3) float32   unit length, for shading
    uvs        (v, 2) float32   texture coordinates, origin at the lower left
    tangents   (v, 3) float32   along the first of them, see `engine.scene.tangents`; or 0
    material   (t,) int32       index into the scene's materials
    object     (t,) int32       index into the scene's objects
    """

    positions: NDArray[np.float32]
    triangles: NDArray[np.int32]
    normals: NDArray[np.float32]
    uvs: NDArray[np.float32]
    tangents: NDArray[np.float32]
    material: NDArray[np.int32]
    object: NDArray[np.int32]


class MaterialTable(NamedTuple):
    """All materials; a kernel argument as it is.

    model     (m,) int32          index into `engine.brdf.table.MODULES`
    row       (m, ROW) float32    parameters, see `engine.brdf.base`
    emission  (m, 3) float32      radiance
    maps      (m, 4) int32        textures that multiply diffuse, specular, roughness, and the one
                                  of normals; -1 is none
    texture   (q, 3) int32        per texture: first texel, width, height
    texels    (k, 3) float32      linear RGB, rows from the bottom up
    """

    model: NDArray[np.int32]
    row: NDArray[np.float32]
    emission: NDArray[np.float32]
    maps: NDArray[np.int32]
    texture: NDArray[np.int32]
    texels: NDArray[np.float32]


@dataclass(frozen=True)
class Scene:
    """Everything that a method or the reference needs to know.

    `materials` are the descriptions in the order of `material_table`; `lights` include the ones
    that are off; `environment` is None where the background is black. `diagnoses` are what the
    loader has to say (an albedo above one, normals that had to be made, ...). `folder` is where the
    files that an edit names are looked for.
    """

    name: str
    camera: Camera
    geometry: Geometry
    material_table: MaterialTable
    material_names: tuple[str, ...]
    materials: tuple[Material, ...]
    object_names: tuple[str, ...]
    lights: tuple[Light, ...]
    environment: Environment | None
    diagnoses: tuple[Diagnosis, ...] = ()
    folder: str = ""

    @cached_property
    def rays(self) -> RayTracer:
        """The ray tracer over `geometry`, built at first use."""
        return RayTracer(self.geometry.positions, self.geometry.triangles)

    @cached_property
    def diagonal(self) -> float:
        """Length of the bounding box's diagonal, metres."""
        p = self.geometry.positions
        return float(np.linalg.norm(p.max(axis=0) - p.min(axis=0)))

    @cached_property
    def transport_digest(self) -> str:
        """Hex digest of what light transport depends on: geometry and materials, no lights."""
        digest = hashlib.blake2b(digest_size=16)
        for array in (*self.geometry, *self.material_table):
            digest.update(repr((array.shape, array.dtype.str)).encode())
            digest.update(np.ascontiguousarray(array).data)
        return digest.hexdigest()

    def with_lights(self, lights: tuple[Light, ...]) -> Scene:
        """The same scene under other lights; geometry and ray tracer are shared."""
        return self._sharing(lights=lights)

    def with_camera(self, camera: Camera) -> Scene:
        """The same scene seen from elsewhere; geometry and ray tracer are shared."""
        return self._sharing(camera=camera)

    def with_environment(self, environment: Environment | None) -> Scene:
        """The same scene in another environment, or in none; geometry and ray tracer are shared."""
        return self._sharing(environment=environment)

    def _sharing(self, **changes: object) -> Scene:
        other = replace(self, **changes)  # type: ignore[arg-type]
        for name in ("rays", "diagonal", "transport_digest"):
            if name in self.__dict__:
                other.__dict__[name] = self.__dict__[name]
        return other
