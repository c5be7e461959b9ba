"""Tiles of 8 x 8 pixels: which pixels share a list of wavelets."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.numerics.packed import TILE

SIDE = 8


def pixel_tiles(width: int, height: int) -> NDArray[np.int32]:
    """(tiles, 64) int32: pixels of each tile in quad-tree order, -1 past the picture's edge.

    Every fourth is one of the pixels of every second row and column.
    """
    bit = np.arange(TILE)[:, None] >> np.arange(6) & 1
    x, y = bit[:, ::2] @ (1, 2, 4), bit[:, 1::2] @ (1, 2, 4)
    down, across = -(-height // SIDE), -(-width // SIDE)
    top, left = np.divmod(np.arange(down * across), across)
    py, px = top[:, None] * SIDE + y, left[:, None] * SIDE + x
    return np.where((py < height) & (px < width), py * width + px, -1).astype(np.int32)


def coarse_tiles(width: int, height: int) -> NDArray[np.int32]:
    """(tiles, 16) int32: every fourth pixel, by its number in the picture of every second one."""
    full = pixel_tiles(width, height)[:, ::4]
    y, x = np.divmod(full, width)
    return np.where(full >= 0, y // 2 * -(-width // 2) + x // 2, -1).astype(np.int32)


def run_tiles(n: int) -> NDArray[np.int32]:
    """(n / 64, 64) int32: runs of consecutive points; the last is padded with -1."""
    index = np.full(-(-n // TILE) * TILE, -1, np.int32)
    index[:n] = np.arange(n)
    return index.reshape(-1, TILE)
