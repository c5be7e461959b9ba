"""How much of the sky is seen from many places: cube maps by the rasteriser, `glossy_prt` §4.1."""

from __future__ import annotations

from typing import Any

import moderngl
import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import Device, gl_errors
from engine.numerics.cube_map import FACES

EYES = 32  # at a time: the target is so many faces high, and has 16384 rows at most
CLIP_DISTANCE_0 = 0x3000  # GL's number of the first of four


class CubeVisibility:
    """Looks around within the triangles of one scene."""

    def __init__(
        self,
        device: Device,
        positions: NDArray[np.float32],
        triangles: NDArray[np.int32],
        near: float,
    ) -> None:
        """Uploads positions (v, 3) and triangles (t, 3). What is nearer than `near` metres to an
        eye is not seen. Raises BackendError where GL fails, as `open_parts`.
        """
        self._device, self._near = device, near
        with gl_errors():
            self._eyes = device.floats(3 * FACES * EYES)
            self._program = device.drawing("passes/blocked.glsl")
            self._mesh = device.context.vertex_array(
                self._program,
                [
                    (device.upload(positions), "3f", "in_position"),
                    (self._eyes, "3f/i", "in_eye"),
                ],
                device.upload(triangles),
            )
        self._size = 0
        self._blocked: Any = None
        self._target: Any = None

    def open_parts(
        self, eye: NDArray[np.float32], normal: NDArray[np.float32], *, light: int, fine: int
    ) -> NDArray[np.uint8]:
        """(b, 6 light²) uint8: how many of a texel's (fine / light)² parts are open.

        eye, normal (b, 3) float32; below the horizon of the normal all is closed. The texels are
        those of `engine.numerics.cube_map`, the parts those of one of `fine` texels a face.
        """
        out = np.zeros((len(eye), FACES * light * light), np.uint8)
        with gl_errors():
            self._device.require_own_thread()
            self._device.context.gc()
            if fine != self._size:
                self._make_target(fine)
            for k in range(0, len(eye), EYES):
                some = slice(k, k + EYES)
                self._draw(eye[some])
                out[some] = self._count(normal[some], light, fine // light)
            self._device.check()
        return out

    def _make_target(self, size: int) -> None:
        context = self._device.context
        self._blocked = context.texture((FACES * size, EYES * size), 1)
        self._blocked.filter = moderngl.NEAREST, moderngl.NEAREST
        self._target = context.framebuffer([self._blocked])
        self._size = size

    def _draw(self, eye: NDArray[np.float32]) -> None:
        """Mark in the texture what every eye sees blocked."""
        context = self._device.context
        self._device.write(self._eyes, np.repeat(eye, FACES, axis=0))
        self._program["u_eyes"].value = EYES
        self._program["u_near"].value = self._near
        self._target.use()
        self._target.clear()
        context.enable_only(moderngl.NOTHING)
        for k in range(4):
            context.enable_direct(CLIP_DISTANCE_0 + k)
        self._mesh.render(instances=FACES * len(eye))
        for k in range(4):
            context.disable_direct(CLIP_DISTANCE_0 + k)

    def _count(self, normal: NDArray[np.float32], light: int, parts: int) -> NDArray[np.uint8]:
        out = np.zeros((len(normal), FACES * light * light), np.uint8)
        found = self._device.room(out.nbytes)
        self._blocked.use(0)
        buffers = {"b_normals": self._device.upload(normal), "b_open": found}
        program = self._device.program("passes/open_parts.glsl")
        words = out.nbytes // 4
        program.run(words, buffers, u_blocked=0, u_count=words, u_light=light, u_parts=parts)
        found.read_into(out, out.nbytes)
        return out
