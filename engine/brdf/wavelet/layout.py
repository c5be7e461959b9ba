"""How an encoded BRDF lies in memory: one block of bytes, read alike by kernels, shaders and files.

    header   HEADER int32: what is where
    floats   float32: root, ranges, ratios of θ, of φ, shares of θ, of φ, floor; int32: schedule
    map      uint16 (nodes,): which row; 0 is all zero and not stored
    rows     uint16 (rows, tiles across · tiles down), from row 1 on: which tile; 0 is all zero
    tiles    uint8 (tiles, 1 + rows · (TILE + 1) · channels), from tile 1 on: scale, then codes

A *node* is a place of the binary tree over outgoing directions, numbered as in a heap: 1 is the
root, 2 k and 2 k + 1 are the children of k. The *plane* is that of incident directions. A tile
holds the coefficients of one node for TILE intervals of the plane each way, the samples at both of
its ends included, so that four neighbours always lie in one tile.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

VERSION = 1
TILE = 8
GENERAL, ORTHOTROPIC, ISOTROPIC = 0, 1, 2
SYMMETRIES = ("general", "orthotropic", "isotropic")

HEADER = 18
(
    SYMMETRY, THETA_BITS, PHI_BITS, ACROSS, DOWN, CHANNELS, SCHEDULE, ROOT, RANGES, THETA_RATIOS,
    PHI_RATIOS, THETA_SHARES, PHI_SHARES, MAP, FIRST_ROW, FIRST_TILE, FLOOR, _,
) = range(HEADER)  # fmt: skip


class Block(NamedTuple):
    """The block as numbers of each kind; kernels make it from an address.

    header  (HEADER,) int32 places of the floats and of SCHEDULE are counted in floats, of MAP and
                            FIRST_ROW in uint16, of FIRST_TILE in bytes, from the block's start
    floats  (n,) float32    the block
    words   (n,) uint16
    octets  (n,) uint8
    """

    header: NDArray[np.int32]
    floats: NDArray[np.float32]
    words: NDArray[np.uint16]
    octets: NDArray[np.uint8]


def block(data: NDArray[np.uint8]) -> Block:
    """The views of a block's bytes (n,), n a multiple of 4."""
    return Block(data.view(np.int32)[:HEADER], data.view(np.float32), data.view(np.uint16), data)


def schedule(theta_bits: int, phi_bits: int) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """((depth, 3), (bits, 2)) int32: how the tree of outgoing directions is split.

    Of each split from the root down, which angle it cuts (0 is θ, 1 is φ) and how many bits of
    either are still to be decided after it; of each bit, the lowest first, the depths at which it
    is decided of θ and of φ.

    Analysis goes from the leaves, θ first, in turns, until one angle is used up (§4.2).
    """
    left, rows = [0, 0], []
    for k in range(theta_bits + phi_bits):
        turn = k % 2 if k < 2 * min(theta_bits, phi_bits) else int(phi_bits > theta_bits)
        rows.append((turn, *left))
        left[turn] += 1
    splits = np.array(rows[::-1], np.int32).reshape(-1, 3)
    depths = np.zeros((max(theta_bits, phi_bits), 2), np.int32)
    for k, (angle, *bits) in enumerate(splits):
        depths[bits[angle], angle] = k
    return splits, depths
