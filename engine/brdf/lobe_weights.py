"""What the elements of a lobe take from light that is even within cells around given directions.

For the second bounce of `brdf_editing` (Ben-Artzi et al. 2008), §4.3: radiance L_k arrives in the
cells of N directions, and of it element j of curve l sends on to wo

    Σ_k W_jk(wo) L_k,    W_jk = ∫_cell k  q_l(wi, wo) b_j(γ) cos θ_i dω

with the dense quadrature of `equivalent_albedo`, so that energy is kept however narrow an element
is, and none goes without light.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.curve_basis import Basis, weights_at
from engine.brdf.equivalent_albedo import ROUND, angles
from engine.brdf.layers import CONSTANTS, LAYERS, direction_at, factors
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec

GRID = 64  # of the disk on which the nearest direction is looked up


def lobe_weights(
    cut: int,
    p: NDArray[np.float32],
    count: int,
    basis: Basis,
    views: NDArray[np.float64],
    directions: NDArray[np.float64],
) -> NDArray[np.float32]:
    """(v, curves, count, N) W of the quotients that p makes.

    views (v, 3) are the wo, directions (N, 3) those with the cells; local, unit, z > 0.
    """
    layers = LAYERS[cut]
    assert layers is not None
    cosine, solid = angles(count)
    out = np.zeros((len(views), layers.curves, count, len(directions)), np.float32)
    for_ranges(
        _weights, len(views), cut, p, basis == "tents", layers.mirrored, views,
        nearest_on_disk(directions), cosine, solid, out, grain=1,
    )  # fmt: skip
    return out


def nearest_on_disk(directions: NDArray[np.float64]) -> NDArray[np.int32]:
    """(GRID, GRID) int32: which direction (N, 3) lies nearest to (x, y) of a unit direction."""
    centre = (np.arange(GRID) + 0.5) * 2 / GRID - 1
    x, y = np.meshgrid(centre, centre)
    length = np.maximum(1.0, np.hypot(x, y))
    x, y = x / length, y / length
    w = np.stack([x, y, np.sqrt(np.maximum(0, 1 - x * x - y * y))], axis=-1)
    return (w @ directions.T).argmax(axis=-1).astype(np.int32)


@njit(cache=True, nogil=True)
def _weights(start, stop, cut, p, tents, mirrored, views, nearest, cosine, solid, out):
    step = 2.0 * np.pi / ROUND
    for v in range(start, stop):
        wo = vec(views, v)
        for i in range(cosine.shape[0]):
            for r in range(ROUND):
                d, jacobian = direction_at(cosine[i], (r + 0.5) * step, wo, mirrored)
                area = solid[i] * step * jacobian
                if d[2] <= 0.0 or area <= 0.0:
                    continue
                x = min(GRID - 1, int(0.5 * (d[0] + 1.0) * GRID))
                y = min(GRID - 1, int(0.5 * (d[1] + 1.0) * GRID))
                k = nearest[y, x]
                f = factors(cut, p, d, wo)
                j, here, there = weights_at(f[0], out.shape[2], tents)
                for c in range(out.shape[1]):
                    value = area * d[2] * f[1 + CONSTANTS + c]
                    out[v, c, j, k] += here * value
                    if there > 0.0:
                        out[v, c, j + 1, k] += there * value
