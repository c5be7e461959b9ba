"""The pixels and sub-samples that show a scene, whatever its materials are at the moment."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.base import DIFFUSE, GRAIN, SPECULAR
from engine.methods.brdf_editing.arriving import Surface
from engine.methods.fixed_view.view import View
from engine.numerics.parallel import for_ranges
from engine.scene.scene import MaterialTable

TEXTURED = 7  # places of a row that textures multiply


class Places:
    """Pixels' centres, then the sub-samples of those at edges."""

    def __init__(self, view: View, table: MaterialTable) -> None:
        """The table is that which the view was made with."""
        buffer = view.buffer

        def joined(name: str) -> NDArray[Any]:
            both = getattr(buffer.centre, name), getattr(buffer.sub, name)
            return np.concatenate(both)

        count = len(buffer.centre)
        edge = np.full(count, -1, np.int32)
        edge[buffer.edge] = np.arange(len(buffer.edge), dtype=np.int32)
        material, row = joined("material"), joined("row")
        camera = view.scene.camera
        grid = np.arange(count, dtype=np.int32).reshape(camera.height, camera.width)
        self._pixels = {1: grid.ravel(), 2: np.ascontiguousarray(grid[::2, ::2]).ravel()}
        self._there: NDArray[np.bool_] = material >= 0
        self._grain = row[:, GRAIN:]
        constant = table.row[material, :TEXTURED]
        ratio = row[:, :TEXTURED] / np.where(constant > 0, constant, 1)
        self._texture = np.where(constant > 0, ratio, 1).astype(np.float32)
        self._surface = Surface(
            joined("position"), joined("normal"), joined("geometric"), joined("view"),
            joined("size"), material, joined("model"), row,
            np.ascontiguousarray(self._texture[:, DIFFUSE : DIFFUSE + 3]),
            np.ascontiguousarray(self._texture[:, SPECULAR : SPECULAR + 3]), edge, buffer.donor,
        )  # fmt: skip
        self._known = table, self._of(table)
        self.mean_gloss = self._mean_gloss(len(table.model))
        """(m, 3): means of textures of the specular reflectance, as seen; 1 for what is not."""

    def surface(self, table: MaterialTable) -> Surface:
        """All of them with the materials of a table; the last one's are kept."""
        known = self._known[0]
        if not (np.array_equal(known.row, table.row) and np.array_equal(known.model, table.model)):
            self._known = table, self._of(table)
        return self._known[1]

    def _of(self, table: MaterialTable) -> Surface:
        material = self._surface.material
        row = np.zeros((len(material), table.row.shape[1]), np.float32)
        for_ranges(
            _fill, len(row), table.row, material, self._texture, self._grain, row, grain=4096
        )
        model = np.where(self._there, table.model[material], -1).astype(np.int32)
        return self._surface._replace(model=model, row=row)

    def _mean_gloss(self, materials: int) -> NDArray[np.float64]:
        centre = slice(len(self._surface.edge))
        material, gloss = self._surface.material[centre], self._surface.gloss[centre]
        shown = material >= 0
        count = np.bincount(material[shown], minlength=materials)
        total = [np.bincount(material[shown], c[shown], minlength=materials) for c in gloss.T]
        return np.where(count, total / np.maximum(count, 1), 1).T

    def pixels(self, scale: int) -> NDArray[np.int32]:
        """(k,): every scale-th pixel of every scale-th row; scale 1 or 2."""
        return self._pixels[scale]

    def showing(self, material: int, scale: int) -> NDArray[np.int32]:
        """(m,) int32: the pixels of those that show a material, wholly or in part."""
        edge = self._surface.edge
        mine = self._surface.material == material
        whole = mine[: len(edge)] & (edge < 0)
        part = mine[len(edge) :].reshape(-1, 4).any(axis=1)
        whole[edge >= 0] = part[edge[edge >= 0]]
        every = self._pixels[scale]
        return every[whole[every]]


@njit(cache=True, nogil=True)
def _fill(start, stop, table, material, texture, grain, out):
    """Rows of materials, times textures, with the grain of each point where they have one."""
    for i in range(start, stop):
        m, brushed = material[i], False
        for c in range(table.shape[1]):
            value = table[m, c]
            if c < TEXTURED:
                out[i, c] = value * texture[i, c]
            elif c < GRAIN:
                out[i, c] = value
            else:
                brushed = brushed or value != 0.0
        if brushed:
            for c in range(GRAIN, table.shape[1]):
                out[i, c] = grain[i, c - GRAIN]
