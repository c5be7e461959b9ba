"""A polar grid over the sphere about a mirror direction, finer towards it: it resolves any lobe."""

from __future__ import annotations

from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

SMALLEST = 1e-5  # angle of the innermost ring, radians


class Grid(NamedTuple):
    """Cells of a coarse grid of rings x sectors, each cut into sub-cells.

    edges       (rings + 1,) angles from the axis, radians
    sectors     number of azimuth sectors
    directions  (rings, sectors, k, 3) unit, centres of the sub-cells
    weights     (rings, sectors, k) solid angles of the sub-cells
    frame       (3, 3) rows s, t, axis
    """

    edges: NDArray[np.float64]
    sectors: int
    directions: NDArray[np.float64]
    weights: NDArray[np.float64]
    frame: NDArray[np.float64]


def about_mirror(
    wo: NDArray[np.float64], rings: int = 36, sectors: int = 12, split: int = 18
) -> Grid:
    """The grid about the mirror image of wo; logarithmic up to a radian, then even."""
    axis = np.array([-wo[0], -wo[1], wo[2]])
    s = np.cross(axis, [1.0, 0.0, 0.0])
    s /= np.linalg.norm(s)
    frame = np.stack([s, np.cross(axis, s), axis])
    inner = rings // 2
    edges = np.concatenate(
        [[0.0], np.geomspace(SMALLEST, 0.5, inner), np.linspace(0.5, np.pi, rings - inner + 1)[1:]]
    )
    rings = len(edges) - 1
    fine = np.concatenate(
        [np.linspace(a, b, split, endpoint=False) for a, b in pairwise(edges)] + [[np.pi]]
    )
    middle = 0.5 * (fine[:-1] + fine[1:])
    band = 2 * np.sin(middle) * np.sin(0.5 * np.diff(fine))
    phi = (np.arange(sectors * split) + 0.5) * 2 * np.pi / (sectors * split)
    local = np.stack(
        np.broadcast_arrays(
            np.sin(middle)[:, None] * np.cos(phi),
            np.sin(middle)[:, None] * np.sin(phi),
            np.cos(middle)[:, None],
        ),
        axis=-1,
    )
    weights = np.broadcast_to(band[:, None] * 2 * np.pi / len(phi), local.shape[:2])

    def cells(array: NDArray[np.float64]) -> NDArray[np.float64]:
        tail = array.shape[2:]
        a = array.reshape(rings, split, sectors, split, *tail).swapaxes(1, 2)
        return np.ascontiguousarray(a).reshape(rings, sectors, split * split, *tail)

    return Grid(edges, sectors, cells(local @ frame), cells(weights), frame)


def counts(grid: Grid, directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """How many of directions (n, 3) fall into each cell: (rings, sectors)."""
    local = directions @ grid.frame.T
    # The chord keeps digits near the axis where the cosine has none.
    chord = np.linalg.norm(directions - grid.frame[2], axis=1)
    angle = 2 * np.arcsin(np.minimum(1.0, chord / 2))
    ring = np.clip(np.searchsorted(grid.edges, angle, side="right") - 1, 0, len(grid.edges) - 2)
    phi = np.arctan2(local[:, 1], local[:, 0]) % (2 * np.pi)
    sector = np.minimum((phi / (2 * np.pi) * grid.sectors).astype(int), grid.sectors - 1)
    flat = np.bincount(ring * grid.sectors + sector, minlength=(len(grid.edges) - 1) * grid.sectors)
    return flat.reshape(len(grid.edges) - 1, grid.sectors).astype(np.float64)
