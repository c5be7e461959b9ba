"""How much of the sky each vertex sees by the rasteriser of a GPU, as in `glossy_prt` §4.1."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import device
from engine.backend.gl.visibility import CubeVisibility
from engine.errors import BackendError, InputError
from engine.methods.glossy_prt.occluders import Occluders

NEAR = 1e-3  # of the ray tracer's epsilon: all that vertices are moved off their surface


class GlVisibility:
    """`open_parts` of `visibility` for one scene and one resolution.

    The GL context is that of the thread in which it is called first, and of no other.
    """

    def __init__(self, occluders: Occluders, light: int, fine: int) -> None:
        self._occluders, self._light, self._fine = occluders, light, fine
        self._made: CubeVisibility | None = None

    def __call__(self, eye: NDArray[np.float32], normal: NDArray[np.float32]) -> NDArray[np.uint8]:
        """(b, 6 light²) uint8 of eye, normal (b, 3). Raises InputError where there is no GL."""
        positions, triangles, rays, skip = self._occluders
        near = max(NEAR * rays.epsilon, skip)
        try:
            if self._made is None:
                self._made = CubeVisibility(device(), positions, triangles, near)
            return self._made.open_parts(eye, normal, light=self._light, fine=self._fine)
        except BackendError as error:
            raise InputError(f"gl does not work here: {error}", field="visibility") from None
