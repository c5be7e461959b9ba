"""The product of transport vectors with a light on the GPU; see `engine.backend.cpu.vectors`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import MOST_GROUPS, Device
from engine.numerics.cube_map import FACES
from engine.numerics.wavelet_vectors import WaveletVectors

VECTORS = 4  # that a work group takes
DEFINES = {"FACES": FACES, "VECTORS": VECTORS}


class Part(NamedTuple):
    """The vectors of one material.

    first     row of the light-dependent vectors where the first term of the first one goes
    terms     K of each vector: it has K channels, or K of red, K of green, K of blue
    vectors   of some vertices, in their order
    """

    first: int
    terms: int
    vectors: WaveletVectors


class _Uploaded(NamedTuple):
    buffers: dict[str, Any]
    uniforms: dict[str, int]


class SparseVectors:
    """Vectors that lie on the GPU, and what a light makes of them."""

    def __init__(self, device: Device, *sets: list[Part]) -> None:
        """Uploads the vectors. Sets are added up: each has a part for every row, or no part."""
        self._device = device
        self._parts = [
            _upload(device, part, add=number > 0)
            for number, parts in enumerate(sets)
            for part in parts
        ]
        ends = [part.first + len(part.vectors.length) * part.terms for part in sets[0]]
        self._out = device.floats(3 * max(ends))
        self._light: Any = None

    def multiply(self, light: NDArray[np.float32]) -> Any:
        """The buffer of the light-dependent vectors, (rows, 3) float32: the same every time.

        light (6 n², 3) float32 holds the Haar coefficients of its faces.
        """
        if self._light is None:
            self._light = self._device.room(light.nbytes)
        self._light.write(np.ascontiguousarray(light))
        program = self._device.program("passes/vectors.glsl", DEFINES)
        for buffers, uniforms in self._parts:
            program.run_groups(
                min(-(-uniforms["u_count"] // VECTORS), MOST_GROUPS),
                {**buffers, "b_light": self._light, "b_lit": self._out},
                u_size=len(light) // FACES, **uniforms,
            )  # fmt: skip
        return self._out


def _upload(device: Device, part: Part, *, add: bool) -> _Uploaded:
    v = part.vectors
    buffers = {
        "b_start": device.upload(v.start.astype(np.int32)),
        "b_base": device.upload(v.base),
        "b_scale": device.upload(v.scale),
        "b_place": device.upload(_whole_words(v.place)),
        "b_steps": device.upload(_whole_words(v.steps)),
    }
    uniforms = {
        "u_count": len(v.length),
        "u_terms": part.terms,
        "u_channels": v.scale.shape[1] // part.terms,
        "u_first": part.first,
        "u_add": int(add),
    }
    return _Uploaded(buffers, uniforms)


def _whole_words(array: NDArray[Any]) -> NDArray[np.uint32]:
    """The bytes of an array as words of four, zeros behind them."""
    data = np.frombuffer(np.ascontiguousarray(array), np.uint8)
    return np.pad(data, (0, -len(data) % 4)).view(np.uint32)
