"""What a camera sees, found on the GPU: triangles by the rasteriser, rays where those do not do.

Rays are cast at edges, at pixels where the rasteriser's rounding is in doubt, and at all pixels
where something is so near that it would be cut off. See `engine.methods.free_view`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.bvh import build_tree
from engine.backend.gl.context import Device
from engine.backend.gl.raster import TriangleIds
from engine.scene.camera import SUBSAMPLES, Camera
from engine.scene.scene import Geometry

TRIANGLE = np.dtype(
    [
        ("a", np.float32, 3),
        ("material", np.int32),
        ("b", np.float32, 3),
        ("object", np.int32),
        ("c", np.float32, 3),
        ("unused", np.int32),
    ]
)
SEEN = 16  # bytes of what one ray meets
CENTRE = ((0.0, 0.0),) * 4


class Seen(NamedTuple):
    """What rays through pixels meet, as `shaders/common/seen.glsl` has it.

    shape   (height, width)
    centre  height · width rays, row by row from the top
    edge    1 + m int32: how many pixels have sub-samples, and which those are, in no certain order
    edges   m
    sub     4 m rays
    rays    uniforms that tell the directions of the rays
    """

    shape: tuple[int, int]
    centre: Any
    edge: Any
    edges: int
    sub: Any
    rays: dict[str, Any]


class Sight:
    """Looks at the triangles of one scene."""

    def __init__(self, device: Device, geometry: Geometry, near: float, step: float) -> None:
        """Rays are cast where surfaces come nearer than `near` metres.

        An edge is where what is seen is farther off than at the next pixel by the part `step`.
        """
        self._device, self._near, self._step = device, near, step
        tree = build_tree(geometry.positions, geometry.triangles)
        self._tree = {
            "b_nodes": device.upload(tree.nodes),
            "b_corners": device.upload(tree.corners),
        }
        corners = geometry.positions[geometry.triangles]
        self._low, self._high = corners.min(axis=1), corners.max(axis=1)
        packed = np.zeros(len(corners), TRIANGLE)
        packed["a"], packed["b"], packed["c"] = corners.swapaxes(0, 1)
        packed["material"], packed["object"] = geometry.material, geometry.object
        self.triangles = device.upload(packed)
        self._ids = TriangleIds(device, geometry.positions, geometry.triangles)

    def look(self, camera: Camera, step: int = 1) -> Seen:
        """What the camera sees through every step-th pixel of every step-th row.

        The whole picture has four sub-samples in each pixel at an edge.
        """
        shape = camera.shape(step)
        n = shape[0] * shape[1]
        from_pixels = np.linalg.inv(camera.to_pixels(step))
        rays = {
            "u_eye": camera.position,
            "u_from_pixels": tuple(from_pixels.T.ravel()),
            "u_width": shape[1],
        }
        centre, edge = self._device.room(SEEN * n), self._device.room(4 * (1 + n))
        if self._is_near(camera, from_pixels, shape):
            self._cast(n, n, edge, centre, rays)
        else:
            self._ids.draw(camera, step, self._near).use(0)
            buffers = {"b_triangles": self.triangles, "b_seen": centre}
            program = self._device.program("passes/seen_drawn.glsl")
            program.run(n, buffers, u_ids=0, u_count=n, **rays)
            self._list_edges(n, centre, edge, rays, in_doubt=True)
            self._cast(-1, n, edge, centre, rays)
        if step > 1:
            return Seen(shape, centre, edge, 0, self._device.room(0), rays)
        self._list_edges(n, centre, edge, rays, in_doubt=False)
        edges = int(np.frombuffer(edge.read(4), np.int32)[0])
        sub = self._device.room(4 * SEEN * edges)
        self._cast(-1, 4 * edges, edge, sub, rays, SUBSAMPLES)
        return Seen(shape, centre, edge, edges, sub, rays)

    def _is_near(
        self, camera: Camera, from_pixels: NDArray[np.floating], shape: tuple[int, int]
    ) -> bool:
        """Whether the eye sees, or may see, something nearer than the rasteriser draws it."""
        rim = np.array([[0, 0, 1], [shape[1], 0, 1], [0, shape[0], 1], [shape[1], shape[0], 1]])
        reach = self._near * np.linalg.norm((rim - [0.5, 0.5, 0]) @ from_pixels.T, axis=1).max()
        eye = np.array(camera.position)
        around = (self._low < eye + reach) & (self._high > eye - reach)
        return bool(around.all(axis=1).any())

    def _list_edges(
        self, n: int, centre: Any, edge: Any, rays: dict[str, Any], *, in_doubt: bool
    ) -> None:
        self._device.write(edge, bytes(4))
        buffers = {"b_triangles": self.triangles, "b_seen": centre, "b_list": edge}
        program = self._device.program("passes/seen_edges.glsl")
        uniforms = {"u_count": n, "u_step": self._step, "u_in_doubt": int(in_doubt)}
        program.run(n, buffers, **uniforms, **rays)

    def _cast(
        self, count: int, rays_at_most: int, edge: Any, seen: Any, rays: dict[str, Any],
        offsets: NDArray[np.float64] | None = None,
    ) -> None:  # fmt: skip
        """Cast rays through all `count` pixels, or, where that is -1, through those in the list."""
        buffers = {
            **self._tree, "b_triangles": self.triangles, "b_list": edge, "b_seen": seen
        }  # fmt: skip
        uniforms = {
            "u_count": count,
            "u_each": 1 if offsets is None else len(offsets),
            "u_offsets": CENTRE if offsets is None else tuple(map(tuple, offsets)),
        }
        program = self._device.program("passes/seen_cast.glsl")
        program.run(rays_at_most, buffers, **uniforms, **rays)
