"""Equivalent albedos of a scene's materials, matt and glossy part by itself."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.brdf import hemispherical_albedo
from engine.brdf.curve_basis import coefficients
from engine.brdf.equivalent_albedo import shares
from engine.brdf.layers import LAYERS
from engine.methods.brdf_editing.settings import Settings
from engine.scene.scene import MaterialTable

Albedos = NDArray[np.float64]
"""(2, m, 3): of the constants, and of the curves, of all materials."""


def albedos_of(table: MaterialTable, settings: Settings, gloss: NDArray[np.float64]) -> Albedos:
    """Those of all materials; what is not cut counts as glossy.

    gloss (m, 3) are means of textures of the specular reflectance.
    """
    out = np.zeros((2, len(table.model), 3))
    for m, model in enumerate(table.model):
        if LAYERS[model] is None:
            out[1, m] = hemispherical_albedo(int(model), table.row[m])[0]
        else:
            row = table.row[m]
            out[:, m] = albedo_of(int(model), row, row, settings, gloss[m])
    return out


def albedo_of(
    cut: int,
    row: NDArray[np.float32],
    taken: NDArray[np.float32],
    settings: Settings,
    gloss: NDArray[np.float64],
) -> NDArray[np.float64]:
    """(2, 3): those of a row whose quotients, one of LAYERS, are `taken` from another."""
    layers = LAYERS[cut]
    assert layers is not None
    colours, lobes = coefficients(layers, row, settings.bands, settings.basis)
    lobes = averaged(lobes, gloss)
    known = shares(cut, taken, settings.bands, settings.basis)
    return np.stack([known.albedo(colours, 0 * lobes), known.albedo(0 * colours, lobes)])


def averaged(lobes: NDArray[np.float64], gloss: NDArray[np.float64]) -> NDArray[np.float64]:
    """Curves (curves, count, 3) as later bounces see them, under a mean texture (3,) (§5.3)."""
    return np.concatenate([lobes[:1] * gloss, lobes[1:]])
