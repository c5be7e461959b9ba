"""Which triangle each pixel shows, by the GPU's rasteriser; see `engine.backend.cpu.raster`."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import Device
from engine.scene.camera import Camera

SHADER = "passes/triangle_ids.glsl"


class TriangleIds:
    """Draws the triangles of one scene; the target of the last size is kept."""

    def __init__(
        self, device: Device, positions: NDArray[np.float32], triangles: NDArray[np.int32]
    ) -> None:
        """Uploads positions (v, 3) and triangles (t, 3)."""
        self._device = device
        self._program = device.drawing(SHADER)
        self._mesh = device.context.vertex_array(
            self._program,
            [(device.upload(positions), "3f", "in_position")],
            device.upload(triangles),
        )
        low, high = positions.min(axis=0), positions.max(axis=0)
        self._bounds = np.stack(np.meshgrid(*zip(low, high, strict=True)), axis=-1).reshape(8, 3)
        self._shape = 0, 0
        self._ids: Any = None
        self._target: Any = None

    def draw(self, camera: Camera, step: int, near: float) -> Any:
        """An integer texture: of each pixel the nearest triangle's number, from 1 on, or 0.

        Through every step-th pixel of every step-th row; row 0 is the top one. What is nearer than
        `near` metres is cut off.
        """
        shape = camera.shape(step)
        if shape != self._shape:
            self._make_target(*shape)
        to_pixels, eye = camera.to_pixels(step), np.array(camera.position)
        far = float(((self._bounds - eye) @ to_pixels[2]).max())
        for name, value in {
            "u_eye": camera.position,
            "u_to_pixels": tuple(to_pixels.T.ravel()),  # column by column
            "u_size": shape[::-1],
            "u_near": near,
            "u_far": 1.01 * max(far, near),  # at 1 the depth is that of nothing
        }.items():
            self._program[name].value = value
        self._target.use()
        self._target.clear()
        # What clear() does to integers is not defined.
        self._device.write(self._ids, bytes(4 * shape[0] * shape[1]))
        self._device.context.enable_only(moderngl.DEPTH_TEST)
        self._mesh.render()
        return self._ids

    def _make_target(self, height: int, width: int) -> None:
        context = self._device.context
        self._ids = context.texture((width, height), 1, dtype="i4")
        self._ids.filter = moderngl.NEAREST, moderngl.NEAREST  # or it holds no integers
        self._target = context.framebuffer([self._ids], context.depth_renderbuffer((width, height)))
        self._shape = height, width
