"""Slices of coefficients, cut into tiles and quantised (Claustres et al. 2007, §4.3, §5.1).

Coefficients of one node are one slice of the paper's 3-D texture, over the plane of incident
directions. The paper leaves out whole slices; where a lobe moves over the plane, most of a slice
is next to nothing but little of it all, so we cut slices into tiles.

Coefficients get 8 bits, in even steps up to the largest of their tile, so that they may be
interpolated as they are.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.brdf.wavelet.analysis import Array
from engine.brdf.wavelet.layout import TILE

STEPS = 127  # of a coefficient, to either side of 0
SCALES = 255  # of a tile, the largest
NOTHING = 1e-6  # of a coefficient: less is rounding


class Tiles(NamedTuple):
    """All tiles of (nodes, down, across, channels) log-ratios, t of them in the plane of a node.

    shape   of the log-ratios
    ranges  (depth,)        the largest coefficient of nodes of each depth
    scales  (nodes, t) uint8                       a tile's largest, of 255 the square
    codes   (nodes, t, rows, TILE + 1, channels) int8   of what `scales` says, of 127
    order   (nodes · t,) int64                     numbers of tiles, the heaviest first
    heavy   int                                    how many hold anything
    """

    shape: tuple[int, ...]
    ranges: Array
    scales: NDArray[np.uint8]
    codes: NDArray[np.int8]
    order: NDArray[np.int64]
    heavy: int

    def kept(self, count: int) -> NDArray[np.bool_]:
        """(nodes, t): the so many heaviest."""
        mask = np.zeros(self.scales.shape, np.bool_)
        mask.reshape(-1)[self.order[:count]] = True
        return mask

    def ratios(self, count: int) -> Array:
        """The log-ratios that so many tiles stand for, 0 in all others."""
        some = self.codes * _steps(self.ranges, self.scales)
        some[~self.kept(count)] = 0
        return _joined(some, self.shape)


def tiles_of(ratios: Array, bright: Array) -> Tiles:
    """Tiles of log-ratios (nodes, down, across, channels).

    A tile weighs what its coefficients mean to the logarithms of the values below its node, and to
    the light that this node reflects, `bright`, (nodes, down, across, 3) of all light.
    """
    tiles = _cut(ratios)
    order, heavy = _by_weight(tiles, _cut(bright))
    return Tiles(ratios.shape, *_quantised(tiles), order, heavy)


def _depths(nodes: int) -> NDArray[np.int64]:
    """(nodes, 1): the depth of each node."""
    return np.frexp(np.arange(1, nodes + 1))[1][:, None] - 1


def _quantised(tiles: Array) -> tuple[Array, NDArray[np.uint8], NDArray[np.int8]]:
    """(ranges, scales, codes): a coefficient is its code times `_steps`."""
    depths, largest = _depths(len(tiles)), np.abs(tiles).max(axis=(2, 3, 4))
    ranges = np.array([largest[depths[:, 0] == k].max() for k in range(depths.max() + 1)])
    ranges = np.where(ranges > NOTHING, ranges, 1.0)
    scales = np.ceil(SCALES * np.sqrt(largest / ranges[depths]))
    scales = np.clip(scales, 1, SCALES).astype(np.uint8)
    codes = np.rint(tiles / _steps(ranges, scales)).astype(np.int8)
    return ranges, scales, codes


def _steps(ranges: Array, scales: NDArray[np.uint8]) -> Array:
    """What one step of a code is, by tile: of the range of its depth the square of the scale."""
    part = (scales / SCALES) ** 2 / STEPS
    return (ranges[_depths(len(scales))] * part)[..., None, None, None]


def _cut(slices: NDArray[Any]) -> NDArray[Any]:
    """(nodes, t, rows, TILE + 1, channels): tiles of slices, with both their ends."""
    down, across = slices.shape[1:3]
    tall, wide = _plane(down, across)
    high = TILE if down > 1 else 0
    padded = np.pad(
        slices,
        ((0, 0), (0, tall * high + 1 - down), (0, wide * TILE + 1 - across), (0, 0)),
        mode="edge",
    )
    rows = (np.arange(tall) * high)[:, None] + np.arange(high + 1)
    columns = (np.arange(wide) * TILE)[:, None] + np.arange(TILE + 1)
    tiles = padded[:, rows[:, None, :, None], columns[None, :, None, :]]
    return tiles.reshape(len(tiles), tall * wide, *tiles.shape[3:])


def _joined(tiles: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """The inverse of `_cut`."""
    n, down, across, channels = shape
    tall, wide = _plane(down, across)
    high = max(1, tiles.shape[2] - 1)
    whole = tiles[:, :, :high, :TILE].reshape(n, tall, wide, high, TILE, channels)
    whole = whole.transpose(0, 1, 3, 2, 4, 5).reshape(n, tall * high, wide * TILE, channels)
    return whole[:, :down, :across]


def _plane(down: int, across: int) -> tuple[int, int]:
    """(tall, wide): tiles down and across a slice."""
    return -(-down // TILE) if down > 1 else 1, -(-across // TILE)


def _by_weight(tiles: Array, bright: Array) -> tuple[NDArray[np.int64], int]:
    """(tiles by number, the heaviest first; how many hold anything).

    Half a coefficient is what the logarithms of the leaves below it are off without.
    """
    leaves = 2.0 ** -_depths(len(tiles))[..., None, None, None]
    samples = tiles[0].size / tiles.shape[-1]
    both = leaves / samples + bright.mean(axis=-1, keepdims=True)
    weight = (np.abs(tiles) * both).sum(axis=(2, 3, 4))
    heavy = np.abs(tiles).max(axis=(2, 3, 4)) > NOTHING
    weight *= heavy
    return np.argsort(-weight.ravel(), kind="stable"), int(heavy.sum())
