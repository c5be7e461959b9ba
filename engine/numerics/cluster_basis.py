"""Vectors of neighbouring vertices in a basis of their own: clustered principal components.

Sloan, Hall, Hart, Snyder 2003 and Liu, Sloan, Shum, Snyder 2004 compress precomputed transport so;
Wang, Tran, Luebke 2006 (`glossy_prt`, §6) name it as what they would do next. All vectors of a
cluster, of all its vertices and channels, are rows of one matrix A of Haar coefficients, and

    A ≈ W B,    W (rows, m),  B (m, places)

with as few components m and as few places as an error allows. A product with a light then is one of
B for the cluster, m numbers, and one of W, m to a number, in place of a hundred coefficients for
every vector. Both are stored in eight bits: B with a unit for each place, W with one for each
component and channel.

The last component is none of the principal ones. It sets right, to eight bits of what is lacking,
the product with light that is the same from everywhere.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.numerics.cube_map import FACES
from engine.numerics.wavelet_vectors import WaveletVectors, before

STEPS = 127  # the largest number of a unit
FIRST = 32  # components that are looked for at first; twice as many while they are too few
ROUNDS = 2  # of subspace iteration
IN_PLACES = 0.5  # of the error: what leaving places out may add
RANK = 1e-12  # square of what is nothing beside the largest
TINY = np.float32(1e-30)


class Clusters(NamedTuple):
    """s clusters of vectors of c channels, vertex after vertex.

    vertices  (s,) int32          how many there are in each
    rank      (s,) int32          components m
    length    (s,) int32          places p
    place     (Σ p,) uint16       Haar coefficients, ascending in each cluster
    unit      (Σ p,) float32      what a step of the basis is
    basis     (Σ p m,) int8       place after place
    scale     (Σ m, c) float32    what a step of the weights is
    weights   (Σ c m n,) int8     of n vertices, channel after channel, component after component
    """

    vertices: NDArray[np.int32]
    rank: NDArray[np.int32]
    length: NDArray[np.int32]
    place: NDArray[np.uint16]
    unit: NDArray[np.float32]
    basis: NDArray[np.int8]
    scale: NDArray[np.float32]
    weights: NDArray[np.int8]


class Starts(NamedTuple):
    """(s,) int64 each: where the numbers of every cluster begin in the arrays of `Clusters`."""

    vertices: NDArray[np.int64]
    place: NDArray[np.int64]
    basis: NDArray[np.int64]
    scale: NDArray[np.int64]
    weights: NDArray[np.int64]


def starts(clusters: Clusters) -> Starts:
    """Of all clusters."""
    n, m, p = (a.astype(np.int64) for a in clusters[:3])
    c = clusters.scale.shape[1]
    return Starts(before(n), before(p), before(p * m), before(m), before(c * m * n))


def cluster(
    vectors: WaveletVectors,
    white: NDArray[np.float32],
    weight: NDArray[np.float32],
    error: float,
) -> Clusters:
    """All vectors as one cluster.

    white (6 n²,) float32 is that of `wavelet_vectors.white_light`, weight (c,) float32 tells how
    much the channels count against each other. What is left out is not much more than the part
    `error` of the norm of all vectors together.
    """
    count, channels = vectors.scale.shape
    place, rows = _rows(vectors, len(white))
    counts = np.tile(np.maximum(weight, TINY), count)[:, None]
    basis = _principal(rows * counts, error)
    kept = _kept_places(place, basis, len(white), IN_PLACES * error)
    if len(basis):
        basis = np.concatenate([basis, _even(rows, basis, place, len(white))])
    of_white = rows.astype(np.float64) @ white[place]
    place, rows, basis = place[kept], rows[:, kept], basis[:, kept]

    steps, unit = _in_steps(basis)
    basis = (steps * unit).astype(np.float64)
    fitted = np.zeros((count, channels, len(basis)))
    fitted[..., :-1] = (_fitted(rows * counts, basis[:-1]) / counts).reshape(fitted[..., :-1].shape)
    weights, scale = _in_steps(fitted)
    if len(basis):
        # What the others lack of white light is for the last component.
        lack = of_white.reshape(count, channels) - (weights * scale) @ (basis @ white[place])
        weights[..., -1:], scale[..., -1:] = _in_steps(lack[..., None] / (basis[-1] @ white[place]))
    return Clusters(
        vertices=np.array([count], np.int32),
        rank=np.array([len(basis)], np.int32),
        length=np.array([len(place)], np.int32),
        place=place.astype(np.uint16),
        unit=unit,
        basis=steps.T.ravel(),
        scale=np.ascontiguousarray(scale.T),
        weights=weights.transpose(1, 2, 0).ravel(),
    )


def _rows(vectors: WaveletVectors, texels: int) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """(places (p,) that any vector has, the vectors (count · c, p)), channel by channel of each."""
    count, channels = vectors.scale.shape
    scaling = np.arange(FACES) * (texels // FACES)
    place, column = np.unique(np.concatenate([scaling, vectors.place]), return_inverse=True)
    rows = np.zeros((count, len(place), channels), np.float32)
    rows[:, column[:FACES]] = vectors.base
    vertex = np.repeat(np.arange(count), vectors.length)
    rows[vertex, column[FACES:]] = vectors.steps * vectors.scale[vertex]
    return place, rows.swapaxes(1, 2).reshape(count * channels, len(place))


def _principal(rows: NDArray[np.float32], error: float) -> NDArray[np.float32]:
    """(m, places): the principal components that hold all rows but a part `error` of their norm.

    By randomised subspace iteration (Halko, Martinsson, Tropp 2011, algorithm 4.4). A component's
    norm is the square root of its singular value: half of it is for the weights, so that eight bits
    serve both alike.
    """
    whole = float((rows.astype(np.float64) ** 2).sum())
    random, many = np.random.default_rng(0), FIRST
    while whole > 0:
        many = min(many, *rows.shape)
        q = rows @ random.standard_normal((rows.shape[1], many), np.float32)
        for _ in range(ROUNDS):
            q = rows @ (rows.T @ _orthonormal(q))
        within = _orthonormal(q).T @ rows
        square, turn = np.linalg.eigh(_square(within.T))
        square, found = square[::-1], turn.T[::-1].astype(np.float32) @ within
        enough = np.flatnonzero(whole - np.cumsum(square) <= error**2 * whole)
        if len(enough) or many == min(rows.shape):
            m = enough[0] + 1 if len(enough) else many
            # Rows of `found` have their singular values for norms.
            return found[:m] / np.maximum(square[:m, None], TINY) ** 0.25
        many *= 2
    return np.zeros((0, rows.shape[1]), np.float32)


def _square(columns: NDArray[np.float32]) -> NDArray[np.float64]:
    """The products (k, k) of columns (n, k) with each other."""
    exact = columns.astype(np.float64)
    return exact.T @ exact


def _orthonormal(columns: NDArray[np.float32]) -> NDArray[np.float32]:
    """A basis (n, ≤ k) of what columns (n, k) span; ten times as fast as QR where n is large."""
    square, turn = np.linalg.eigh(_square(columns))
    there = square > RANK * square[-1]
    return columns @ (turn[:, there] / np.sqrt(square[there])).astype(np.float32)


def _kept_places(
    place: NDArray[np.int64], basis: NDArray[np.float32], texels: int, error: float
) -> NDArray[np.bool_]:
    """(p,): the scaling coefficients, and the largest but a part `error` of the norm of all."""
    power = (np.linalg.norm(basis, axis=1)[:, None] ** 2 * basis**2).sum(axis=0)
    order = np.argsort(power, kind="stable")
    kept = np.zeros(len(place), np.bool_)
    kept[order] = np.cumsum(power[order], dtype=np.float64) > error**2 * power.sum()
    return kept | (place % (texels // FACES) == 0) & (power > 0)


def _even(
    rows: NDArray[np.float32], basis: NDArray[np.float32], place: NDArray[np.int64], texels: int
) -> NDArray[np.float32]:
    """(1, p): scaling coefficients as the rows have them, no larger than those of the basis."""
    most = np.abs(basis).max(axis=0)
    mean = np.abs(rows).mean(axis=0)
    there = (place % (texels // FACES) == 0) & (most > 0) & (mean > 0)
    out = np.where(there, mean, 0)
    return (out * (most[there] / out[there]).min())[None].astype(np.float32)


def _in_steps(values: NDArray[Any]) -> tuple[NDArray[np.int8], NDArray[np.float32]]:
    """Values (n, ...) in eight bits, and what a step is, (...)."""
    step = (np.abs(values).max(axis=0, initial=0) / STEPS).astype(np.float32)
    return np.round(values / np.maximum(step, TINY)).astype(np.int8), step


def _fitted(rows: NDArray[np.float32], basis: NDArray[Any]) -> NDArray[Any]:
    """(rows, m): weights of the basis (m, p) that come nearest to the rows (r, p)."""
    return rows @ basis.T @ np.linalg.pinv(basis @ basis.T, rcond=1e-10, hermitian=True)
