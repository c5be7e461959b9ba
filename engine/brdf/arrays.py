"""The BRDF contract over arrays: what tests, charts and loaders call; integrators call `table`."""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import ArrayLike, NDArray

from engine.brdf import table
from engine.brdf.base import ROW
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import vec


def evaluate(
    model: ArrayLike, rows: ArrayLike, wi: ArrayLike, wo: ArrayLike
) -> NDArray[np.float64]:
    """BRDF in sr⁻¹, without the cosine: (n, 3).

    model () or (n,) index into MODULES; rows (ROW,) or (n, ROW); wi, wo (3,) or (n, 3), unit
    length, local (z the normal), leaving the surface. Lengths of one are repeated.
    """
    n, steps, arrays = _together(model, rows, wi, wo)
    out = np.zeros((n, 3))
    for_ranges(_evaluate, n, *arrays, steps, out)
    return out


def sample(model: ArrayLike, rows: ArrayLike, wo: ArrayLike, u: ArrayLike) -> NDArray[np.float64]:
    """Incident directions (n, 3) with density `pdf`; z ≤ 0 where the light is lost.

    wo as for `evaluate`; u (3,) or (n, 3) in [0, 1).
    """
    n, steps, arrays = _together(model, rows, wo, u)
    out = np.zeros((n, 3))
    for_ranges(_sample, n, *arrays, steps, out)
    return out


def pdf(model: ArrayLike, rows: ArrayLike, wi: ArrayLike, wo: ArrayLike) -> NDArray[np.float64]:
    """Density of `sample` over solid angle, sr⁻¹: (n,); arguments as for `evaluate`."""
    n, steps, arrays = _together(model, rows, wi, wo)
    out = np.zeros(n)
    for_ranges(_pdf, n, *arrays, steps, out)
    return out


def broadcast(
    model: ArrayLike, rows: ArrayLike, a: ArrayLike, b: ArrayLike
) -> tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float64], NDArray[np.float64]]:
    """Contiguous (n,), (n, ROW), (n, 3), (n, 3); ValueError where the lengths do not fit."""
    n, _, (models, parameters, first, second) = _together(model, rows, a, b)
    # Copies, or one of a length of one would be read-only, for which kernels are compiled again.
    return (
        np.broadcast_to(models, n).copy(),
        np.broadcast_to(parameters, (n, ROW)).copy(),
        np.broadcast_to(first, (n, 3)).copy(),
        np.broadcast_to(second, (n, 3)).copy(),
    )


Arrays = tuple[NDArray[np.int32], NDArray[np.float32], NDArray[np.float64], NDArray[np.float64]]


def _together(
    model: ArrayLike, rows: ArrayLike, a: ArrayLike, b: ArrayLike
) -> tuple[int, tuple[int, int, int, int], Arrays]:
    """(n, steps, arrays): item i is at i times its step, so that what is one is not copied."""
    models = np.atleast_1d(np.ascontiguousarray(model, np.int32))
    parameters = np.atleast_2d(np.ascontiguousarray(rows, np.float32))
    first = np.atleast_2d(np.ascontiguousarray(a, np.float64))
    second = np.atleast_2d(np.ascontiguousarray(b, np.float64))
    last = len(table.MODULES) - 1
    if models.size and not 0 <= models.min() <= models.max() <= last:
        raise ValueError(f"a model index lies outside 0 to {last}")
    for array, columns in ((parameters, ROW), (first, 3), (second, 3)):
        if array.shape[1:] != (columns,):
            raise ValueError(f"an array is {array.shape}, not (n, {columns})")
    arrays = models, parameters, first, second
    n = np.broadcast_shapes(*[(len(x),) for x in arrays])[0]
    one, two, three, four = (int(len(x) > 1) for x in arrays)
    return n, (one, two, three, four), arrays


@njit(cache=True, nogil=True)
def _evaluate(start, stop, models, rows, wi, wo, steps, out):
    m, r, p, q = steps
    for i in range(start, stop):
        out[i, 0], out[i, 1], out[i, 2] = table.evaluate(
            models[i * m], rows[i * r], vec(wi, i * p), vec(wo, i * q)
        )


@njit(cache=True, nogil=True)
def _sample(start, stop, models, rows, wo, u, steps, out):
    m, r, p, q = steps
    for i in range(start, stop):
        out[i, 0], out[i, 1], out[i, 2] = table.sample(
            models[i * m], rows[i * r], vec(wo, i * p), vec(u, i * q)
        )


@njit(cache=True, nogil=True)
def _pdf(start, stop, models, rows, wi, wo, steps, out):
    m, r, p, q = steps
    for i in range(start, stop):
        out[i] = table.pdf(models[i * m], rows[i * r], vec(wi, i * p), vec(wo, i * q))
