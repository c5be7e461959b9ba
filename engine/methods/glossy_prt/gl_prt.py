"""The pictures of a `Prt` on the GPU: what `view` and `views` do, with one read-back."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import Device, Uploads, gl_errors
from engine.backend.gl.seen import Seen, Sight
from engine.brdf.base import DIFFUSE, SPECULAR
from engine.light.environment import Environment, is_same
from engine.light.environment_samples import RIM
from engine.light.far_disk import NO_DISK, radius_of
from engine.methods.free_view import NEAR, STEP
from engine.methods.glossy_prt.vertices import Vertices
from engine.methods.glossy_prt.views import LOWEST, Maps
from engine.scene.camera import SUBSAMPLES, Camera
from engine.scene.scene import Geometry, MaterialTable, Scene

Clock = Callable[[str], AbstractContextManager[None]]
Multiply = Callable[[Environment | None], Any]
FOLDER = "methods/glossy_prt"
NO_MAP = np.zeros(0, np.float32)

# The layouts of std430: a vec3 and the number behind it share sixteen bytes.
MATERIAL = np.dtype(
    [
        ("emission", np.float32, 3),
        ("first", np.int32),
        ("diffuse", np.float32, 3),
        ("vertex", np.int32),
        ("specular", np.float32, 3),
        ("terms", np.int32),
        ("diffuse_map", np.int32, 3),
        ("size", np.int32),
        ("specular_map", np.int32, 3),
        ("texel", np.int32),
        ("textured", np.int32),
        ("unused", np.int32, 3),
    ]
)
VERTEX = np.dtype([("normal", np.float32, 4), ("tangent", np.float32, 4)])


class GlPrt:
    """Draws what `Prt` draws; the last light and the last view are kept."""

    def __init__(
        self, device: Device, scene: Scene, vertices: Vertices, maps: Maps, multiply: Multiply
    ) -> None:
        """Uploads everything that frames have in common. Raises BackendError where it cannot.

        multiply turns an environment into the buffer of the light-dependent vectors, (rows, 3)
        float32, as `Prt.lit`.
        """
        self._device, self._multiply = device, multiply
        self._lit: tuple[Environment | None, Any] | None = None
        self._view: tuple[Camera, int, Seen] | None = None
        self._map = Uploads(device)
        geometry, materials = scene.geometry, scene.material_table
        with gl_errors():
            self._sight = Sight(device, geometry, NEAR * scene.diagonal, STEP)
            of_triangle = np.column_stack([vertices.corners, vertices.smooth]).astype(np.int32)
            self._buffers = {
                "b_triangles": self._sight.triangles,
                "b_of_triangle": device.upload(of_triangle),
                "b_vertices": device.upload(_packed_vertices(vertices)),
                "b_materials": device.upload(_packed_materials(materials, maps)),
                "b_h": device.upload(maps.h),
                "b_uvs": device.upload(_uvs(geometry, maps)),
                "b_texels": device.upload(materials.texels),
            }
            device.check()

    def draw(
        self, environment: Environment | None, camera: Camera, scale: int, clock: Clock
    ) -> NDArray[np.float32]:
        """(height, width, 3) float32 radiance. Raises BackendError where GL fails."""
        with gl_errors():
            self._device.require_own_thread()
            self._device.context.gc()
            with clock("transport"):
                lit = self._lit_by(environment)
            with clock("view"):
                view = self._seen(camera, scale)
            with clock("shade"):
                picture = self._shade(lit, view, environment)
            with clock("read_back"):
                image = np.zeros((*view.shape, 3), np.float32)
                picture.read_into(image, image.nbytes)
            self._device.check()
            return image

    def _lit_by(self, environment: Environment | None) -> Any:
        if self._lit is None or not is_same(self._lit[0], environment):
            self._lit = None  # where it fails there is none
            self._lit = environment, self._multiply(environment)
        return self._lit[1]

    def _seen(self, camera: Camera, scale: int) -> Seen:
        if self._view is None or self._view[:2] != (camera, scale):
            self._view = camera, scale, self._sight.look(camera, scale)
        return self._view[2]

    def _shade(self, lit: Any, view: Seen, environment: Environment | None) -> Any:
        """The buffer of the picture."""
        n = view.shape[0] * view.shape[1]
        picture = self._device.room(12 * n)
        buffers = {
            **self._buffers, "b_lit": lit, "b_map": self._map_of(environment), "b_image": picture
        }  # fmt: skip
        uniforms = {**view.rays, **_of_map(environment), "u_lowest": LOWEST}
        program = self._device.program(f"{FOLDER}/shade.glsl")
        program.run(n, {**buffers, "b_seen": view.centre}, u_count=n, **uniforms)
        program = self._device.program(f"{FOLDER}/shade_edges.glsl")
        of_edges = {**buffers, "b_seen": view.sub, "b_list": view.edge}
        offsets = tuple(map(tuple, SUBSAMPLES))
        program.run(view.edges, of_edges, u_offsets=offsets, **uniforms)
        return picture

    def _map_of(self, environment: Environment | None) -> Any:
        return self._map.of("map", NO_MAP if environment is None else environment.radiance)


def _of_map(environment: Environment | None) -> dict[str, Any]:
    """Uniforms of `shaders/light/environment.glsl`; nothing is seen without background."""
    size, shift, factor, disk = (0, 0), 0.0, 0.0, NO_DISK
    if environment is not None and environment.description.background:
        height, width = environment.radiance.shape[:2]
        size, disk = (width, height), environment.disk
        shift = environment.description.rotation_degrees / 360 % 1.0
        factor = environment.description.intensity
    return {
        "u_map": size,
        "u_map_shift": shift,
        "u_map_factor": factor,
        "u_disk": (*disk.axis, radius_of(disk)),
        "u_disk_radiance": disk.radiance,
        "u_rim": RIM,
    }


def _packed_vertices(vertices: Vertices) -> NDArray[Any]:
    packed = np.zeros(len(vertices.normal), VERTEX)
    packed["normal"][:, :3], packed["tangent"][:, :3] = vertices.normal, vertices.tangent
    return packed


def _packed_materials(table: MaterialTable, maps: Maps) -> NDArray[Any]:
    packed = np.zeros(len(maps.terms), MATERIAL)
    packed["emission"], packed["diffuse"] = table.emission, table.row[:, DIFFUSE : DIFFUSE + 3]
    packed["specular"] = table.row[:, SPECULAR : SPECULAR + 3]
    for name in ("first", "vertex", "terms", "size", "texel", "textured"):
        packed[name] = getattr(maps, name)
    for slot, name in enumerate(("diffuse_map", "specular_map")):
        packed[name] = -1
        for m in np.flatnonzero(table.maps[:, slot] >= 0):
            packed[name][m] = table.texture[table.maps[m, slot]]
    return packed


def _uvs(geometry: Geometry, maps: Maps) -> NDArray[np.float32]:
    """(t, 3, 2): texture coordinates near 0, where float32 has the most digits; textures repeat."""
    if not maps.textured.any():
        return np.zeros(0, np.float32)
    uvs = geometry.uvs[geometry.triangles].astype(np.float64)
    return (uvs - np.floor(uvs.min(axis=1, keepdims=True))).astype(np.float32)
