"""The product of transport vectors with a light on the GPU; see `engine.backend.cpu.vectors`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import MOST_GROUPS, Device
from engine.numerics.cluster_basis import Clusters, starts
from engine.numerics.cube_map import FACES
from engine.numerics.wavelet_vectors import WaveletVectors

VECTORS = 4  # that a work group takes
DEFINES = {"FACES": FACES, "VECTORS": VECTORS}


class Part(NamedTuple):
    """The vectors of one material.

    first     row of the light-dependent vectors where the first term of the first one goes
    terms     K of each vector: it has K channels, or K of red, K of green, K of blue
    vectors   of some vertices, in their order, in either form
    """

    first: int
    terms: int
    vectors: WaveletVectors | Clusters


class _Uploaded(NamedTuple):
    shader: str
    defines: dict[str, int]
    groups: int
    buffers: dict[str, Any]
    uniforms: dict[str, int]


class StoredVectors:
    """Vectors that lie on the GPU, and what a light makes of them."""

    def __init__(self, device: Device, texels: int, *sets: list[Part]) -> None:
        """Uploads the vectors, of cube maps of so many texels on the whole.

        Sets are added up: each has a part for every row, or no part.
        """
        self._device = device
        self._parts = [
            _upload(device, part, texels, add=number > 0)
            for number, parts in enumerate(sets)
            for part in parts
        ]
        ends = [part.first + _vertices(part.vectors) * part.terms for part in sets[0]]
        self._out = device.floats(3 * max(ends))
        self._light: Any = None

    def multiply(self, light: NDArray[np.float32]) -> Any:
        """The buffer of the light-dependent vectors, (rows, 3) float32: the same every time.

        light (6 n², 3) float32 holds the Haar coefficients of its faces.
        """
        if self._light is None:
            self._light = self._device.room(light.nbytes)
        self._device.write(self._light, np.ascontiguousarray(light))
        for part in self._parts:
            self._device.program(part.shader, part.defines).run_groups(
                min(part.groups, MOST_GROUPS),
                {**part.buffers, "b_light": self._light, "b_lit": self._out},
                **part.uniforms,
            )
        return self._out


def _vertices(vectors: WaveletVectors | Clusters) -> int:
    if isinstance(vectors, Clusters):
        return int(vectors.vertices.sum())
    return len(vectors.length)


def _upload(device: Device, part: Part, texels: int, *, add: bool) -> _Uploaded:
    v = part.vectors
    uniforms = {
        "u_terms": part.terms,
        "u_channels": v.scale.shape[1] // part.terms,
        "u_first": part.first,
        "u_add": int(add),
    }
    if isinstance(v, Clusters):
        return _upload_clusters(device, v, uniforms)
    buffers = {
        "b_start": device.upload(v.start.astype(np.int32)),
        "b_base": device.upload(v.base),
        "b_scale": device.upload(v.scale),
        "b_place": device.upload(_whole_words(v.place)),
        "b_steps": device.upload(_whole_words(v.steps)),
    }
    count = len(v.length)
    return _Uploaded(
        "passes/vectors.glsl",
        DEFINES,
        -(-count // VECTORS),
        buffers,
        {**uniforms, "u_count": count, "u_size": texels // FACES},
    )


def _upload_clusters(device: Device, v: Clusters, uniforms: dict[str, int]) -> _Uploaded:
    begins = starts(v)
    of_clusters = np.column_stack([v.vertices, v.rank, v.length, *begins]).astype(np.int32)
    buffers = {
        "b_clusters": device.upload(of_clusters),
        "b_place": device.upload(_whole_words(v.place)),
        "b_unit": device.upload(v.unit),
        "b_basis": device.upload(_whole_words(v.basis)),
        "b_scale": device.upload(v.scale),
        "b_weights": device.upload(_whole_words(v.weights)),
    }
    defines = {"RANK": max(1, int(v.rank.max(initial=0)))}
    count = {"u_count": len(v.rank)}
    return _Uploaded("passes/clusters.glsl", defines, len(v.rank), buffers, {**uniforms, **count})


def _whole_words(array: NDArray[Any]) -> NDArray[np.uint32]:
    """The bytes of an array as words of four, zeros behind them."""
    data = np.frombuffer(np.ascontiguousarray(array), np.uint8)
    return np.pad(data, (0, -len(data) % 4)).view(np.uint32)
