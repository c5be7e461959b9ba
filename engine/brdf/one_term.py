"""The best one term that is nowhere negative: normalised decomposition.

Kautz and McCool 1999, *Interactive Rendering with Arbitrary BRDFs using Separable Approximations*:
with the norm of each row as the one factor and the mean of the rows, each divided by its norm, as
the other. Ours is the integral over the view directions for a norm, so that the term reflects
exactly as much from every incident direction as the BRDF does:

    g(wi) = ∫ f(wi, wo) cos θ_o dwo,    h(wo) = mean over wi of f(wi, wo) / g(wi).

It costs no eigenvectors. It is not reciprocal where f is not separable.
"""

from __future__ import annotations

import numpy as np

from engine.brdf import table
from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.factored import Factored, constant
from engine.brdf.factorisation import SIZE, brdf_matrix
from engine.numerics.hemisphere_maps import texels


def normalised(material: Material, size: int = SIZE, *, polar: bool = False) -> Factored:
    """One term of a material; a diffuse one is exact."""
    if isinstance(material, Diffuse):
        return constant(material.diffuse)
    grid = texels(size, polar=polar)
    inner, count = len(grid.weight), len(grid.number)
    solid = np.pi * grid.weight / grid.weight.sum()
    matrix = brdf_matrix(table.INDEX[type(material)], material.row(), grid)
    light = np.zeros((size * size, 1, 3), np.float32)
    view = np.zeros_like(light)
    for c in range(3):
        f = matrix[c].astype(np.float64)
        g = f @ solid
        share = np.where(g[:inner] > 0, solid / np.pi / np.where(g[:inner] > 0, g[:inner], 1), 0)
        light[grid.number[:count], 0, c] = g
        # f is symmetric: its row is its column.
        view[grid.number[:count], 0, c] = f @ share
    shape = (size, size, 1, 3)
    return Factored(light.reshape(shape), view.reshape(shape), polar)
