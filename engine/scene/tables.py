"""Pack materials and their textures for the kernels."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from engine.brdf.base import ROW, Material
from engine.brdf.table import INDEX
from engine.scene.description import TEXTURE_SLOTS
from engine.scene.scene import MaterialTable

Image = NDArray[np.float32]
"""(height, width, 3) float32, linear, rows from the bottom up."""


def material_table(
    materials: Sequence[Material], textures: Sequence[dict[str, Image]]
) -> MaterialTable:
    """The table of materials, each with its images by slot; one image used twice is kept once."""
    places: dict[int, int] = {}
    images: list[Image] = []
    maps = np.full((len(materials), len(TEXTURE_SLOTS)), -1, np.int32)
    for m, slots in enumerate(textures):
        for slot, image in slots.items():
            if id(image) not in places:
                places[id(image)] = len(images)
                images.append(image)
            maps[m, TEXTURE_SLOTS.index(slot)] = places[id(image)]
    texture = np.zeros((len(images), 3), np.int32)
    first = 0
    for q, image in enumerate(images):
        texture[q] = first, image.shape[1], image.shape[0]
        first += image.shape[0] * image.shape[1]
    texels = [image.reshape(-1, 3) for image in images] or [np.zeros((0, 3), np.float32)]
    return MaterialTable(
        np.array([INDEX[type(material)] for material in materials], np.int32),
        rows(materials),
        np.array([material.emission for material in materials], np.float32).reshape(-1, 3),
        maps,
        texture,
        np.ascontiguousarray(np.concatenate(texels), np.float32),
    )


def changed_table(table: MaterialTable, materials: Sequence[Material]) -> MaterialTable:
    """The table with other constants or models; textures stay as they are."""
    return table._replace(
        model=np.array([INDEX[type(material)] for material in materials], np.int32),
        row=rows(materials),
        emission=np.array([m.emission for m in materials], np.float32).reshape(-1, 3),
    )


def rows(materials: Sequence[Material]) -> NDArray[np.float32]:
    """(m, ROW) float32 parameters."""
    return np.array([m.row() for m in materials], np.float32).reshape(len(materials), ROW)
