"""Factor a BRDF by the eigenvectors of its matrix: `glossy_prt` §3.3 (Wang, Tran, Luebke 2006).

The BRDF is tabulated over pairs of texels, M_ij = f(w_i, w_j), each channel by itself. Helmholtz
reciprocity makes M symmetric, so M = Q D Qᵀ, and the K eigenvalues largest in magnitude give the
best K terms in the Frobenius norm. Light map and view map of term k are

    g_k = √|λ_k| q_k, h_k = sign(λ_k) g_k.

About half of the eigenvalues are negative: f peaks where wo is the mirror image of wi and not where
it equals wi, and under a half turn of the map an eigenvector is even or odd. Those of isotropic
models come in pairs of equal eigenvalues, cos and sin of a multiple of the azimuth.

Texels count by their projected solid angle, which on the disk is the same for all. Guards
(`hemisphere_maps`) do not count; they get what Nyström's formula extends an eigenvector to,
q(w) = Σ_j f(w, w_j) q_j / λ, which at a texel is the eigenvector itself.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf import table
from engine.brdf.base import DIFFUSE, SPECULAR, Material
from engine.brdf.diffuse import Diffuse
from engine.brdf.factored import Factored, constant
from engine.numerics.hemisphere_maps import Texels, mirrors, texels
from engine.numerics.mirrors import is_mirrored, largest_eigenpairs
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec

SIZE, TERMS = 48, 4  # what the paper uses
NOTHING = 1e-7  # of the largest eigenvalue: below it there is float32 rounding, and no term


def factor(
    material: Material, terms: int = TERMS, size: int = SIZE, *, polar: bool = False
) -> Factored:
    """The first `terms` terms of a material, fewer where it has no more; one, exact, if diffuse."""
    if isinstance(material, Diffuse):
        return constant(material.diffuse)
    return factor_row(table.INDEX[type(material)], material.row(), terms, size, polar=polar)


def factor_parts(
    material: Material, terms: int = TERMS, size: int = SIZE, *, polar: bool = False
) -> tuple[Factored, Factored]:
    """(base, gloss) for textures: base is for a diffuse reflectance of 1 and one term, which is
    exact but for look-ups; gloss has `terms`, for the material's own specular reflectance.

    f = diffuse · base + gloss, of every model. Where a model is linear in its specular reflectance
    too, see `gloss_is_linear`, a texture may scale the view maps of the gloss as well.
    """
    model, row = table.INDEX[type(material)], material.row()
    gloss, white = row.copy(), row.copy()
    gloss[DIFFUSE : DIFFUSE + 3], white[DIFFUSE : DIFFUSE + 3] = 0, 1
    if isinstance(material, Diffuse):
        return constant((1, 1, 1)), constant((0, 0, 0))
    grid = texels(size, polar=polar)
    lobe = brdf_matrix(model, gloss, grid)
    base = _maps(brdf_matrix(model, white, grid) - lobe, grid, 1)
    if not row[SPECULAR : SPECULAR + 3].any():
        return base, constant((0, 0, 0))
    return base, _maps(lobe, grid, terms)


def factor_row(
    model: int, row: NDArray[np.float32], terms: int, size: int = SIZE, *, polar: bool = False
) -> Factored:
    """`factor` of what the functions of `engine.brdf` take: a model's index and its row (ROW,)."""
    grid = texels(size, polar=polar)
    return _maps(brdf_matrix(model, row, grid), grid, terms)


def brdf_matrix(model: int, row: NDArray[np.float32], grid: Texels) -> NDArray[np.float32]:
    """f, sr⁻¹, of all texels against those that are no guards: (3, m, inner) float32."""
    inner = len(grid.weight)
    out = np.zeros((3, len(grid.number), inner), np.float32)
    for_ranges(_tabulate, len(grid.number), model, row, grid.direction, out, grain=16)
    return out


@njit(cache=True, nogil=True)
def _tabulate(start, stop, model, row, w, out):
    inner = out.shape[2]
    for i in range(start, stop):
        # Reciprocity gives the other half.
        for j in range(min(i + 1, inner)):
            f = table.evaluate(model, row, vec(w, i), vec(w, j))
            for c in range(3):
                out[c, i, j] = f[c]
                if i < inner:
                    out[c, j, i] = f[c]


def eigenpairs(
    matrix: NDArray[np.floating], grid: Texels, terms: int
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(values (K,), vectors (m, K)) with matrix ≈ Σ values q qᵀ, the largest in magnitude first.

    matrix (m, inner) of `brdf_matrix`, one channel. Vectors are orthonormal under the weights of
    the texels. Values that are nothing but rounding are left out, all but one.
    """
    weight, inner = grid.weight, len(grid.weight)
    root = np.sqrt(weight)
    square = np.asarray(matrix[:inner], np.float64) * root[:, None] * root
    # All our models are even about both axes, but a table need not be.
    both = mirrors(grid)
    values, vectors = largest_eigenpairs(square, both if is_mirrored(square, both) else None, terms)
    kept = max(1, int((np.abs(values) > NOTHING * np.abs(values[0])).sum()))
    values, vectors = values[:kept], vectors[:, :kept] / root[:, None]
    # The sign of an eigenvector is a matter of taste; ours is that of its largest entry.
    vectors *= np.sign(vectors[np.abs(vectors).argmax(axis=0), np.arange(kept)])
    if len(matrix) > inner and values[0] != 0:
        beyond = np.asarray(matrix[inner:], np.float64) @ (vectors * weight[:, None]) / values
        vectors = np.concatenate([vectors, beyond])
    return values, vectors


def _maps(matrix: NDArray[np.float32], grid: Texels, terms: int) -> Factored:
    pairs: list[tuple[NDArray[np.float64], NDArray[np.float64]]] = []
    for c in range(3):
        # Grey materials have one channel.
        same = next((k for k in range(c) if np.array_equal(matrix[k], matrix[c])), None)
        pairs.append(pairs[same] if same is not None else eigenpairs(matrix[c], grid, terms))
    kept = max(len(values) for values, _ in pairs)
    light = np.zeros((grid.size * grid.size, kept, 3), np.float32)
    view = np.zeros_like(light)
    for c, (values, vectors) in enumerate(pairs):
        g = np.sqrt(np.abs(values)) * vectors
        light[grid.number[: len(g)], : len(values), c] = g
        view[grid.number[: len(g)], : len(values), c] = np.sign(values) * g
    shape = (grid.size, grid.size, kept, 3)
    return Factored(light.reshape(shape), view.reshape(shape), grid.polar)
