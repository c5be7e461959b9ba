"""The product of packed rows with a light on the GPU; see `engine.backend.cpu.product`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import MOST_GROUPS, Device
from engine.numerics.packed import STEPS, TILE, UNITS

WORD = 4  # steps
DEFINES = {
    "TILE": TILE,
    **{f"WORDS_{k}": count // WORD for k, count in enumerate(STEPS[:3])},
    **{f"UNIT_{k}": unit for k, unit in enumerate(UNITS)},
}


class Rows:
    """A matrix of packed rows that lies on the GPU."""

    def __init__(
        self,
        device: Device,
        length: NDArray[np.int32],
        ids: NDArray[np.int32],
        mean: NDArray[np.float32],
        scale: NDArray[np.float32],
        steps: NDArray[np.int8],
    ) -> None:
        """Arrays as of a `PackedRows`: uploaded once."""
        self._device = device
        counts = length.sum(axis=1), length @ STEPS // WORD, length[:, :-1].sum(axis=1)
        ends = np.cumsum(np.stack(counts, axis=1), axis=0)
        first = np.concatenate([np.zeros((1, 3), np.int64), ends]).astype(np.int32)
        self._buffers = {
            "b_first": device.upload(first),
            "b_length": device.upload(length),
            "b_ids": device.upload(ids),
            "b_mean": device.upload(mean),
            "b_scale": device.upload(scale),
            "b_steps": device.upload(steps),
        }

    def multiply(self, light: Any, places: Places, out: Any) -> None:
        """Matrix times light (n_g, 3), each row to its place in out (n, 3), all buffers."""
        program = self._device.program("passes/product.glsl", DEFINES)
        buffers = {
            **self._buffers, "b_light": light, "b_places": places.buffer, "b_out": out
        }  # fmt: skip
        groups = min(places.tiles, MOST_GROUPS)
        program.run_groups(groups, buffers, u_tiles=places.tiles, u_rows=places.rows)


class Places:
    """Where the rows of tiles go: places (tiles, 64 or 16) int32 of the CPU's `multiply`."""

    def __init__(self, device: Device, places: NDArray[np.int32]) -> None:
        self.tiles, self.rows = places.shape
        self.buffer = device.upload(places)
