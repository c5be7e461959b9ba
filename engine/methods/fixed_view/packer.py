"""From rows of a tile, as rays or links find them, to rows as they are kept."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.methods.fixed_view.packing import pack
from engine.methods.fixed_view.rows import STEPS, TILE, PackedRows, make_scratch, project
from engine.numerics.haar import levels

LONGEST = 8  # a tile's list is at most so many times the coefficients asked for


class Rows(NamedTuple):
    """Rows of a tile as `rows.project` wants them: first (b + 1,), cluster, weight (p,)."""

    first: NDArray[np.int32]
    cluster: NDArray[np.int32]
    weight: NDArray[np.float32]


class Packer:
    """Packs tile after tile, with room for it."""

    def __init__(self, importance: NDArray[np.float32], coefficients: int) -> None:
        self._importance, self._coefficients = importance, coefficients
        self._depth = levels(len(importance))
        self._scratch = make_scratch(len(importance))
        self._ids, self._values = np.zeros(1 << 19, np.int32), np.zeros(1 << 19, np.float32)
        self._starts = np.zeros(TILE + 1, np.int64)
        most = LONGEST * coefficients
        self._wavelets = np.zeros(most, np.int32)
        self._mean, self._scale = np.zeros((2, most), np.float32)
        self._steps = np.zeros(most * TILE, np.int8)
        self._lists: list[PackedRows] = []

    def add(self, rows: Rows, wanted: NDArray[np.bool_]) -> float:
        """Pack a tile, of which some rows are wanted; returns the share of energy that was kept."""
        while True:
            args = (self._depth, self._scratch, self._ids, self._values, self._starts)
            if project(*rows, *args) >= 0:
                break
            room = 2 * len(self._ids)
            self._ids, self._values = np.zeros(room, np.int32), np.zeros(room, np.float32)
        length = np.zeros((1, len(STEPS)), np.int32)
        count, size, kept = pack(
            self._ids, self._values, self._starts, wanted, self._importance, self._coefficients,
            self._scratch, length[0], self._wavelets, self._mean, self._scale, self._steps,
        )  # fmt: skip
        self._lists.append(
            PackedRows(
                length,
                self._wavelets[:count].copy(),
                self._mean[:count].copy(),
                self._scale[:count].copy(),
                self._steps[:size].copy(),
            )
        )
        return float(kept)

    def packed(self) -> PackedRows:
        """All tiles."""
        return PackedRows(*(np.concatenate(parts) for parts in zip(*self._lists, strict=True)))
