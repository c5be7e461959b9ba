"""A BRDF for many pairs of directions on the GPU; see `engine.brdf.arrays`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import Device
from engine.backend.gl.tables import BRDF_TABLE, brdf_table


class Evaluation:
    """n pairs of one material, uploaded once."""

    def __init__(
        self,
        device: Device,
        model: int,
        row: NDArray[np.float32],
        wi: NDArray[np.floating],
        wo: NDArray[np.floating],
    ) -> None:
        """model as an index into MODULES, row (ROW,), local directions (n, 3) and (n, 3)."""
        self._device, self._model, self._count = device, model, len(wi)
        arrays = {"b_row": row, "b_wi": wi, "b_wo": wo}
        self._buffers: dict[str, Any] = {
            name: device.upload(np.ascontiguousarray(array, np.float32))
            for name, array in arrays.items()
        }
        self._buffers["b_value"] = device.floats(3 * self._count)

    def run(self) -> None:
        """Find all values; the GPU is done with it when this returns."""
        program = self._device.program("passes/evaluate.glsl", made={BRDF_TABLE: brdf_table()})
        program.run(self._count, self._buffers, u_count=self._count, u_model=self._model)
        self._device.context.finish()
        self._device.check()

    def read(self) -> NDArray[np.float32]:
        """(n, 3) sr⁻¹."""
        out = np.zeros((self._count, 3), np.float32)
        self._buffers["b_value"].read_into(out, out.nbytes)
        return out
