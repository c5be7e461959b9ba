"""The Haar transform on the GPU; see `engine.numerics.haar`."""

from __future__ import annotations

from typing import Any

from engine.backend.gl.context import Device
from engine.numerics.haar import levels


class Haar:
    """Transforms of n = 4^k three-vectors, with the room that they need."""

    def __init__(self, device: Device, n: int) -> None:
        self._levels = levels(n)
        self._program = device.program("passes/haar.glsl")
        self._scaling = device.floats(n)

    def forward(self, values: Any, out: Any) -> None:
        """Coefficients (n, 3) float32 of values (n, 3) float32, both buffers."""
        buffers = {"b_values": values, "b_scaling": self._scaling, "b_out": out}
        if self._levels == 0:
            raise ValueError("a cloud of one sample has no wavelets")
        for level in range(self._levels - 1, -1, -1):
            finest = level == self._levels - 1
            self._program.run(4**level, buffers, u_parents=4**level, u_finest=int(finest))
