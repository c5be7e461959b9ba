"""Sample a BRDF on the grid that is encoded.

A cell of outgoing directions gets the mean over it, weighed by projected solid angle, so that a
lobe narrower than a cell keeps its light. Where such lobes are, about the mirror image of the
incident direction, the mean is over many more places.

An isotropic BRDF has one azimuth of incident directions and half of the outgoing ones; one that is
the same in a mirror along the grain and in one across it has a quarter of the outgoing ones. So
they need less memory, and nothing is lost.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from engine.brdf.wavelet import layout
from engine.brdf.wavelet.analysis import Grid
from engine.numerics.tangent_poles import directions

BITS = 5  # 32 cells along each angle, as the paper has
WITHIN = 2  # samples of a cell, along each angle
AT_MIRROR = 8  # the same of cells no farther than REACH from the mirror image
REACH = 1.5
MIRRORED = 0.01  # by which a mirrored pair may differ, of the mean of both and of all
PAIRS = 2000
AT_ONCE = 1 << 18


class Source(Protocol):
    """Anything that says what a BRDF is for any pair of directions."""

    @property
    def isotropic(self) -> bool:
        """Whether it stays the same when both directions turn about the normal."""

    def evaluate(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        """(q, 3) sr⁻¹ of unit pairs (q, 3) above the surface."""


def grid_for(source: Source, bits: int = BITS) -> Grid:
    """The grid for a source: 2^bits cells along each angle of the hemisphere.

    The cells of an isotropic one have half the width, for it costs a small part of the others.
    """
    if source.isotropic:
        return Grid(layout.ISOTROPIC, bits + 1, bits, 2 << bits, 1)
    if is_mirrored(source):
        return Grid(layout.ORTHOTROPIC, bits - 1, bits - 1, 1 << bits, 1 << bits)
    return Grid(layout.GENERAL, bits, bits, 1 << bits, 1 << bits)


def is_mirrored(source: Source) -> bool:
    """Whether a BRDF is the same in mirrors along both axes, tried at random pairs."""
    rng = np.random.default_rng(1)
    wi, wo = (directions(*(0.02 + 0.96 * rng.random((2, PAIRS)))) for _ in range(2))
    value = source.evaluate(wi, wo)
    for mirror in ((-1, 1, 1), (1, -1, 1)):
        other = source.evaluate(wi * mirror, wo * mirror)
        scale = 0.5 * (value + other) + value.mean()
        if (np.abs(value - other) > MIRRORED * scale).any():
            return False
    return True


def incident(grid: Grid) -> NDArray[np.float64]:
    """(down, across, 3): the directions of the plane."""
    if grid.symmetry == layout.ISOTROPIC:
        theta = np.arange(grid.across) * np.pi / (2 * grid.across - 1)
        return np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1)[None]
    u = (np.arange(grid.across) + 0.5) / grid.across
    v = (np.arange(grid.down) + 0.5) / grid.down
    return directions(u[None, :], v[:, None])


def outgoing(grid: Grid, dx: float = 0.0, dy: float = 0.0) -> NDArray[np.float64]:
    """(θ, φ, 3): directions in the cells, so much off their centres in parts of a cell."""
    (columns, rows), (width, height) = grid.cells, grid.extent
    u = (np.arange(columns) + 0.5 + dx) / columns * width
    v = (np.arange(rows) + 0.5 + dy) / rows * height
    return directions(u[:, None], v[None, :])


def tabulate(source: Source, grid: Grid, within: int = WITHIN) -> NDArray[np.float32]:
    """(θ, φ, down, across, 3) float32, sr⁻¹: means over within² places of each cell, with 2 or more
    over AT_MIRROR² where highlights may be; with 1 values at their centres.
    """
    wi = incident(grid).reshape(-1, 3)
    total = np.zeros((*grid.cells, len(wi), 3), np.float64)
    weight = np.zeros(grid.cells, np.float64)
    offsets = (np.arange(within) + 0.5) / within - 0.5
    for dx in offsets:
        for dy in offsets:
            wo = outgoing(grid, dx, dy)
            # dω is sin φ dθ dφ.
            share = wo[..., 2] * np.sqrt(1 - wo[..., 1] ** 2)
            total += (
                _evaluated(source, wi, wo.reshape(-1, 3)).reshape(total.shape)
                * (share[..., None, None])
            )
            weight += share
    total /= weight[..., None, None]
    if within > 1:
        _sharpen(source, grid, wi, total)
    return total.reshape(*grid.cells, grid.down, grid.across, 3).astype(np.float32)


def _sharpen(
    source: Source, grid: Grid, wi: NDArray[np.float64], values: NDArray[np.float64]
) -> None:
    """Replace what cells about mirror images have in values (θ, φ, m, 3) by finer means."""
    (columns, rows), (width, height) = grid.cells, grid.extent
    x, y, z = wi.T * [[-1], [-1], [1]]
    u = np.arctan2(z, x) / np.pi / width * columns - 0.5
    v = np.arctan2(np.hypot(x, z), y) / np.pi / height * rows - 0.5
    near = np.abs(np.arange(columns)[:, None, None] - u) <= REACH
    near = near & (np.abs(np.arange(rows)[:, None] - v) <= REACH)
    i, j, k = np.nonzero(near)
    offset = (np.arange(AT_MIRROR) + 0.5) / AT_MIRROR - 0.5
    step = max(1, AT_ONCE // AT_MIRROR**2)
    for first in range(0, len(i), step):
        a, b, c = (index[first : first + step] for index in (i, j, k))
        across = (a[:, None, None] + 0.5 + offset[:, None]) / columns * width
        along = (b[:, None, None] + 0.5 + offset) / rows * height
        wo = directions(across, along).reshape(-1, 3)
        share = wo[:, 2] * np.sqrt(1 - wo[:, 1] ** 2)
        value = source.evaluate(np.repeat(wi[c], AT_MIRROR**2, axis=0), wo) * share[:, None]
        means = value.reshape(len(a), -1, 3).sum(axis=1) / share.reshape(len(a), -1, 1).sum(axis=1)
        values[a, b, c] = means


def _evaluated(
    source: Source, wi: NDArray[np.float64], wo: NDArray[np.float64]
) -> NDArray[np.float64]:
    """(n, m, 3) of n outgoing and m incident directions."""
    step = max(1, AT_ONCE // len(wi))
    parts = []
    for first in range(0, len(wo), step):
        some = wo[first : first + step]
        value = source.evaluate(np.tile(wi, (len(some), 1)), np.repeat(some, len(wi), axis=0))
        parts.append(value.reshape(len(some), len(wi), 3))
    return np.concatenate(parts)
