"""Factor a BRDF into terms that are nowhere negative, so that nothing rings and nothing is clamped.

Lee and Seung 1999, *Learning the Parts of Objects by Non-negative Matrix Factorization*: M ≈ G Hᵀ
with G, H ≥ 0, by the alternating updates of one column at a time of Cichocki and Phan 2009 (HALS),
from the positive parts of eigenvectors (Boutsidis and Gallopoulos 2008). Light and view maps differ
by more than a sign, and the fit is reciprocal only as far as it is good. A first term is the
eigenvector of the largest eigenvalue, which has no negative entry (Perron and Frobenius).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.brdf import table
from engine.brdf.base import Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.factored import Factored, constant
from engine.brdf.factorisation import SIZE, TERMS, brdf_matrix, eigenpairs
from engine.numerics.hemisphere_maps import Texels, texels

ROUNDS = 200
BEYOND_ROUNDS = 20
TINY = 1e-12


def non_negative(
    material: Material, terms: int = TERMS, size: int = SIZE, *, polar: bool = False
) -> Factored:
    """`terms` terms of a material, all maps ≥ 0; one, exact, if it is diffuse."""
    if isinstance(material, Diffuse):
        return constant(material.diffuse)
    grid = texels(size, polar=polar)
    matrix = brdf_matrix(table.INDEX[type(material)], material.row(), grid)
    light = np.zeros((size * size, terms, 3), np.float32)
    view = np.zeros_like(light)
    for c in range(3):
        g, h = _factor_matrix(matrix[c].astype(np.float64), grid, terms)
        light[grid.number, :, c], view[grid.number, :, c] = g, h
    shape = (size, size, terms, 3)
    return Factored(light.reshape(shape), view.reshape(shape), polar)


def _factor_matrix(
    matrix: NDArray[np.float64], grid: Texels, terms: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """G, H (m, K) ≥ 0 with matrix (m, inner) ≈ G Hᵀ, symmetric but for the rows beyond."""
    weight, inner = grid.weight, len(grid.weight)
    root = np.sqrt(weight)[:, None]
    square = matrix[:inner] * root * root.T
    g, h = _start(matrix, grid, terms)
    g, h = g * root, h * root
    for _ in range(ROUNDS):
        _improve(square, g, h)
        _improve(square, h, g)
    g, h = g / root, h / root
    beyond = len(matrix) - inner
    if beyond:
        # The rows beyond follow from the others, whose factors stand.
        more_g, more_h = np.full((2, beyond, terms), 1e-3)
        rows = matrix[inner:] * weight
        for _ in range(BEYOND_ROUNDS):
            _improve(rows, more_g, h, weight[:, None])
            _improve(rows, more_h, g, weight[:, None])
        g, h = np.concatenate([g, more_g]), np.concatenate([h, more_h])
    return g, h


def _improve(
    rows: NDArray[np.float64],
    g: NDArray[np.float64],
    h: NDArray[np.float64],
    weight: NDArray[np.float64] | float = 1.0,
) -> None:
    """Set each column of g to its best, the others and h as they are; rows are weighed already."""
    across, among = rows @ h, h.T @ (h * weight)
    for k in range(g.shape[1]):
        step = (across[:, k] - g @ among[:, k]) / max(among[k, k], TINY)
        g[:, k] = np.maximum(g[:, k] + step, 0)


def _start(
    matrix: NDArray[np.float64], grid: Texels, terms: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of each eigenpair λ q qᵀ the larger of its two non-negative parts."""
    inner = len(grid.weight)
    values, vectors = eigenpairs(matrix, grid, terms)
    g, h = np.full((2, inner, terms), 1e-3 * np.sqrt(max(abs(values[0]), TINY) / inner))
    for k, value in enumerate(values):
        q = vectors[:inner, k]
        plus, minus = np.maximum(q, 0), np.maximum(-q, 0)
        if value > 0:
            g[:, k] += np.sqrt(value) * (plus if plus @ plus >= minus @ minus else minus)
            h[:, k] = g[:, k]
        else:
            g[:, k] += np.sqrt(-value) * plus
            h[:, k] += np.sqrt(-value) * minus
    return g, h
