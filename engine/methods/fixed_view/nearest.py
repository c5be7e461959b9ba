"""The gather sample nearest to a place on a surface, and turned the same way."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

CELLS = 160  # along the longest side of the box, at most


class Grid(NamedTuple):
    """Samples sorted into the cells of a grid; a kernel argument as it is.

    low       (3,) float64        corner of the box that all samples lie in
    size      float               m, edge of a cell
    counts    (3,) int64          cells each way
    start     (cells + 1,) int32  first sample of each cell, the third direction fastest
    sample    (n,) int32          the samples in the order of their cells
    features  (n, 7) float32      position, scaled normal and scale, in that order too
    spacing   (n,) float32        m, of each sample: the scale of its normal
    """

    low: NDArray[np.float64]
    size: float
    counts: NDArray[np.int64]
    start: NDArray[np.int32]
    sample: NDArray[np.int32]
    features: NDArray[np.float32]
    spacing: NDArray[np.float32]


def build_grid(
    position: NDArray[np.float32], normal: NDArray[np.float32], area: NDArray[np.float32]
) -> Grid:
    """Over samples at position, with unit normal (n, 3) float32, standing for area (n,) m²."""
    places = position.astype(np.float64)
    low, high = places.min(axis=0), places.max(axis=0)
    spacing = np.sqrt(area)
    middle = math.sqrt(float(area.mean(dtype=np.float64)))
    size = max(middle, float((high - low).max()) / CELLS, 1e-12)
    cell = ((places - low) / size).astype(np.int64)
    counts = cell.max(axis=0) + 1
    key = (cell[:, 0] * counts[1] + cell[:, 1]) * counts[2] + cell[:, 2]
    sample = np.argsort(key, kind="stable").astype(np.int32)
    start = np.searchsorted(key[sample], np.arange(int(counts.prod()) + 1)).astype(np.int32)
    bend = spacing[:, None]
    features = np.concatenate([position, bend * normal, bend], axis=1)[sample]
    return Grid(low, size, counts, start, sample, np.ascontiguousarray(features), spacing)


@njit
def nearest(grid, x, n):
    """Index of the sample p with the least |p - x|² + spacing_p² |n_p - n|² from place x, normal n.

    The same as eq. 9 of Hašan et al. 2006 with normals weighed by the spacing of the samples, so
    that of two sides of a sheet, or two walls of a corner, each keeps to its own.
    """
    return nearest_beyond(grid, x, n, np.float32(-1.0))[0]


@njit
def nearest_beyond(grid, x, n, beyond):
    """(index, that sum of squares) of the nearest sample that is farther than `beyond`.

    The index is -1 where there is none.
    """
    f = (np.float32(x[0]), np.float32(x[1]), np.float32(x[2]))
    m = (np.float32(n[0]), np.float32(n[1]), np.float32(n[2]))
    nx, ny, nz = grid.counts
    cx = min(max(int((x[0] - grid.low[0]) / grid.size), 0), nx - 1)
    cy = min(max(int((x[1] - grid.low[1]) / grid.size), 0), ny - 1)
    cz = min(max(int((x[2] - grid.low[2]) / grid.size), 0), nz - 1)
    ring = 1
    while True:
        best, found = np.float32(np.inf), -1
        z0, z1 = max(0, cz - ring), min(nz, cz + ring + 1)
        # Columns of cells from the middle outwards: most are then too far away.
        for i in range(2 * ring + 1):
            ix = cx + (i + 1) // 2 * (1 - 2 * (i % 2))
            gap_x = _gap(grid.low[0] + ix * grid.size, grid.size, x[0])
            if ix < 0 or ix >= nx or gap_x * gap_x >= best:
                continue
            for j in range(2 * ring + 1):
                iy = cy + (j + 1) // 2 * (1 - 2 * (j % 2))
                gap_y = _gap(grid.low[1] + iy * grid.size, grid.size, x[1])
                if iy < 0 or iy >= ny or gap_x * gap_x + gap_y * gap_y >= best:
                    continue
                column = (ix * ny + iy) * nz
                for k in range(grid.start[column + z0], grid.start[column + z1]):
                    d = np.float32(0.0)
                    for c in range(3):
                        e = grid.features[k, c] - f[c]
                        h = grid.features[k, 3 + c] - grid.features[k, 6] * m[c]
                        d += e * e + h * h
                    if beyond < d < best:
                        best, found = d, k
        # Whatever lies beyond the ring is at least so far off.
        if best <= (ring * grid.size) ** 2 or ring > max(nx, ny, nz):
            return grid.sample[found] if found >= 0 else -1, best
        ring *= 2


@njit
def _gap(low, size, x):
    """How far x lies outside of what begins at `low` and is so long."""
    return max(0.0, low - x, x - low - size)
