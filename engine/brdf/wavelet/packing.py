"""Write a code as the block of bytes of `layout`."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.wavelet import layout
from engine.brdf.wavelet.analysis import Array, Grid
from engine.brdf.wavelet.tiles import SCALES, STEPS, Tiles


def packed(grid: Grid, floor: Array, mean: Array, tiles: Tiles, count: int) -> NDArray[np.uint8]:
    """The block of so many tiles, mean and floor by channel. Equal tiles are stored once."""
    theta, phi = grid.weights
    splits = layout.schedule(grid.theta_bits, grid.phi_bits)
    parts: list[tuple[int, NDArray[Any]]] = [
        (layout.ROOT, np.log(mean)),
        (layout.RANGES, tiles.ranges / (STEPS * SCALES**2)),
        (layout.THETA_RATIOS, _heap(theta, ratios=True)),
        (layout.PHI_RATIOS, _heap(phi, ratios=True)),
        (layout.THETA_SHARES, _heap(theta, ratios=False)),
        (layout.PHI_SHARES, _heap(phi, ratios=False)),
        (layout.FLOOR, floor),
        (layout.SCHEDULE, np.concatenate([part.ravel() for part in splits])),
    ]
    header = np.zeros(layout.HEADER, np.int32)
    floats = [header.view(np.float32)]
    size = layout.HEADER
    for place, part in parts:
        header[place] = size
        plain = part if part.dtype == np.int32 else part.astype(np.float32)
        floats.append(plain.ravel())
        size += part.size
    kept, codes = tiles.kept(count), tiles.codes
    some = (codes[kept] + np.int16(128)).astype(np.uint8)
    some = some.reshape(len(some), int(np.prod(codes.shape[2:])))
    some = np.concatenate([tiles.scales[kept][:, None], some], axis=1)
    stored, which = np.unique(some, axis=0, return_inverse=True)
    numbers = np.zeros(kept.shape, np.uint16)
    numbers[kept] = which.ravel() + 1
    filled = kept.any(axis=1)
    filling = numbers[filled]
    rows, row = np.unique(filling, axis=0, return_inverse=True)
    nodes = np.zeros(len(kept), np.uint16)
    nodes[filled] = row.ravel() + 1
    header[layout.MAP] = 2 * size
    header[layout.FIRST_ROW] = 2 * size + len(nodes)
    header[layout.FIRST_TILE] = 4 * size + nodes.nbytes + rows.nbytes
    header[layout.SYMMETRY], header[layout.THETA_BITS] = grid.symmetry, grid.theta_bits
    header[layout.PHI_BITS], header[layout.ACROSS] = grid.phi_bits, grid.across
    header[layout.DOWN], header[layout.CHANNELS] = grid.down, codes.shape[-1]
    arrays: list[NDArray[Any]] = [*floats, nodes, rows.ravel(), stored.ravel()]
    data = [part.view(np.uint8) for part in arrays]
    # Whole words, and room to read four octets at the last.
    room = -sum(map(len, data)) % 4 + 4
    return np.concatenate([*data, np.zeros(room, np.uint8)])


def bytes_of_tiles(tiles: Tiles, count: int) -> int:
    """What so many tiles and their rows add to a block at most."""
    rows = int(tiles.kept(count).any(axis=1).sum())
    return 2 * rows * tiles.scales.shape[1] + count * (1 + tiles.codes[0, 0].nbytes)


def _heap(weights: Array, *, ratios: bool) -> Array:
    """Of one angle's cells (n,): for each node k from 1 on, w_2k+1 / w_2k, or 1 / w_k."""
    level, levels = weights, [weights]
    while len(level) > 1:
        level = level[0::2] + level[1::2]
        levels.append(level)
    whole = np.concatenate([[1.0], *levels[::-1]])
    return whole[3::2] / whole[2::2] if ratios else 1 / whole
