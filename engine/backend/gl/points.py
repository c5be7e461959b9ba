"""Surface points on the GPU, as `shaders/common/points.glsl` reads them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import Device
from engine.brdf.base import ROW

# The layout of std430: a vec3 and the number behind it share sixteen bytes.
POINT = np.dtype(
    [
        ("position", np.float32, 3),
        ("size", np.float32),
        ("normal", np.float32, 3),
        ("model", np.int32),
        ("geometric", np.float32, 3),
        ("phase", np.int32),
        ("view", np.float32, 3),
        ("unused", np.float32),
        ("row", np.float32, ROW),
    ]
)


class Surface:
    """n points; `buffer` is theirs."""

    def __init__(
        self,
        device: Device,
        position: NDArray[np.float32],
        normal: NDArray[np.float32],
        geometric: NDArray[np.float32],
        view: NDArray[np.float32],
        model: NDArray[np.int32],
        row: NDArray[np.float32],
        phase: NDArray[np.uint8],
        size: NDArray[np.float32],
    ) -> None:
        """Shapes as of `engine.methods.fixed_view.frame_buffer.Points`: uploaded once."""
        self.count = len(model)
        packed = np.zeros(self.count, POINT)
        packed["position"], packed["size"] = position, size
        packed["normal"], packed["model"] = normal, model
        packed["geometric"], packed["phase"] = geometric, phase
        packed["view"], packed["row"] = view, row
        self.buffer: Any = device.upload(packed)
