"""How much of the sky each vertex sees, texel by texel of a cube map, by rays.

`glossy_prt` §4.1 rasterises 6 x 128 x 128 texels from every vertex and averages them down to
6 x 64 x 64. Most of that is plainly open or plainly blocked: here a coarse map comes first, and a
cell is looked at more finely only where it and the cells around it do not agree, level by level, so
that rays go to silhouettes. What is so small that no coarse ray meets it is missed.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.glossy_prt.occluders import Occluders
from engine.numerics import cube_map
from engine.numerics.vec import dot, vec

OPEN, BLOCKED, UNKNOWN, BELOW = 0, 1, 2, 3

OpenParts = Callable[[NDArray[np.float32], NDArray[np.float32]], NDArray[np.uint8]]
"""`open_parts` of (eye, normal) for one scene and one resolution, however it is found."""

TOGETHER = 64  # vertices whose visibility is found at a time: it takes much memory


def open_parts(
    occluders: Occluders,
    eye: NDArray[np.float32],
    normal: NDArray[np.float32],
    *,
    light: int,
    fine: int,
    coarse: int,
) -> NDArray[np.uint8]:
    """(b, 6 light²) uint8: how many of a texel's (fine / light)² parts are open.

    eye, normal (b, 3) float32 of b vertices; below the horizon of the normal all is closed.
    `fine` is light or twice that; the coarse map has `coarse` texels along a face, or `fine` where
    that is less.
    """
    level = min(coarse, fine)
    known = np.full((len(eye), cube_map.FACES * (level // 2) ** 2), UNKNOWN, np.uint8)
    while True:
        # The last level is not kept cell by cell: a texel whose parts agree is one number.
        last = level == fine and level > light
        cells = known.shape[1] if last else 4 * known.shape[1]
        state = np.zeros((len(eye), cells), np.uint8)
        asked = np.zeros((4 * known.size, 2), np.int32)
        around = cube_map.neighbours(level // 2)
        count = _refine(known, normal, around, *_cells(level), last, state, asked)
        vertex, cell = asked[:count, 0], asked[:count, 1]
        directions = cube_map.directions(level).astype(np.float32)
        hit = occluders.blocks(eye[vertex], directions[cell])
        if last:
            np.add.at(state, (vertex[~hit], cell[~hit] // 4), 1)
            return state
        state[vertex, cell] = hit
        if level == fine:
            return (state == OPEN).astype(np.uint8)
        known, level = state, 2 * level


def _cells(level: int) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """(directions of a level's cells, those of the level above, half the width of the latter)."""
    return cube_map.directions(level), cube_map.directions(level // 2), math.sqrt(2) / (level // 2)


@njit(cache=True, nogil=True)
def _refine(known, normal, around, directions, parents, reach, last, state, asked):
    """Fill state from the states `known` of the level above; list (vertex, cell) to be asked.

    state (b, 4 p) holds the states of cells or, at the last level, (b, p) how many of four are
    open. Returns the length of the list.
    """
    count = 0
    for i in range(known.shape[0]):
        n = vec(normal, i)
        for parent in range(known.shape[1]):
            height = dot(n, vec(parents, parent))
            if height < -reach:
                if last:
                    state[i, parent] = 0
                else:
                    state[i, 4 * parent : 4 * parent + 4] = BELOW
                continue
            agreed = known[i, parent]
            for k in range(around.shape[1]):
                other = known[i, around[parent, k]]
                if other != BELOW and other != agreed:
                    agreed = other if agreed == BELOW else UNKNOWN
                    if agreed == UNKNOWN:
                        break
            if agreed == BELOW:
                agreed = UNKNOWN
            if last:
                state[i, parent] = 0
            for cell in range(4 * parent, 4 * parent + 4):
                above = height > reach or dot(n, vec(directions, cell)) > 0.0
                if not last:
                    state[i, cell] = agreed if above else BELOW
                elif above and agreed == OPEN:
                    state[i, parent] += 1
                if above and agreed == UNKNOWN:
                    asked[count, 0], asked[count, 1] = i, cell
                    count += 1
    return count
