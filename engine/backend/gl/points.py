"""Surface points on the GPU, as `shaders/common/points.glsl` reads them."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import Device
from engine.brdf.base import ROW
from engine.numerics.parallel import for_ranges

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
        room: Surface | None = None,
    ) -> None:
        """Shapes as of `engine.methods.fixed_view.frame_buffer.Points`: uploaded once.

        `room` is another one that is not needed any more: where it has as many points, its buffer
        is written into, since a new one takes several times as long.
        """
        self.count = len(model)
        packed = np.zeros(self.count, POINT)
        parts: dict[str, NDArray[Any]] = {
            "position": position, "size": size, "normal": normal, "model": model,
            "geometric": geometric, "phase": phase, "view": view, "row": row,
        }  # fmt: skip

        def pack(start: int, stop: int) -> None:
            for name, part in parts.items():
                packed[name][start:stop] = part[start:stop]

        for_ranges(pack, self.count, grain=1 << 16)
        self.buffer: Any
        if room is not None and room.count == self.count > 0:
            self.buffer = room.buffer
            device.write(self.buffer, packed)
        else:
            self.buffer = device.upload(packed)
