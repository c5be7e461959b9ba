"""Choose a tile's wavelets, and how much of each, and write them in eight bits.

The 64 coefficients of one wavelet are Haar-transformed over the points of the tile. The mean over
the tile is one number; where the points are alike, it says nearly all, and what differs from point
to point is mostly the noise of rays. So of each wavelet the coarsest 1, 4, 16 or all 64 are kept,
or none. With n of them go their noise, n `ray_noise`; without them goes what they truly are, Σ F²
less that noise. So they are worth Σ F² - 2 n noise, weighed by the `importance` of the wavelet, and
a byte of them must be worth PRICE of the last coefficient that a row would keep with the asked
number of them and a list of its own (Hašan et al. 2006, §3.3).

Error in the light that view samples reflect, relative L2 against rows of 8,192 rays without
culling, mean of moved lamps, points, spots of 20 and of 10 degrees, sixteen in all, that no
precompute knows; MB of the final rows, 100 coefficients:

    PRICE              1/16       1/12       1/4        1/2        1          2
    Cornell, 512²      11.8 4.5%  11.0 4.5%   8.3 4.6%   6.8 5.0%   5.5 5.7%   4.5 6.4%
    room, 512 x 384    14.7 6.0%  13.8 6.1%  10.6 7.2%   8.7 8.3%   7.1 9.5%   5.7 11.1%
    living, 640 x 480  29.9 3.6%  28.2 3.6%  22.0 4.0%  18.3 4.4%  14.9 4.9%  11.9 5.7%

By energy alone, at a price of 1/2, it was 32.5 MB 9.5 %, 22.4 8.7 % and 39.2 4.3 %, and more
coefficients made Cornell worse: what they added was noise. Four bits in place of eight for the
steps gain nothing once noise is left out.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.ray_noise import (
    cluster_of,
    forget_noise,
    make_landed,
    ray_noise,
)
from engine.methods.fixed_view.rows import PackedRows, Rows, make_scratch, project
from engine.numerics import haar
from engine.numerics.borrow import borrow
from engine.numerics.packed import STEPS, TILE, step_units

transform = haar.transform
UNIT_OF = step_units()
PRICE = 1 / 12
# Bytes of a wavelet, and of the steps that lead from none to 4, with their scale, to 16, to 64.
COSTS = (8.0, 8.0, 12.0, 48.0)

LONGEST = 8  # a tile's list is at most so many times the coefficients asked for


class Packer:
    """Packs tile after tile, with room for it."""

    def __init__(
        self, importance: NDArray[np.float32], coefficients: int, chance: float = 1.0
    ) -> None:
        """importance (n_g,) and coefficients as `pack` wants them; chance as `ray_noise`."""
        self._importance, self._coefficients = importance, coefficients
        self._chance = chance
        self._depth = haar.levels(len(importance))
        self._scratch, self._landed = make_scratch(len(importance)), make_landed(len(importance))
        self._ids, self._values = np.zeros(1 << 19, np.int32), np.zeros(1 << 19, np.float32)
        self._starts = np.zeros(TILE + 1, np.int64)
        most = LONGEST * coefficients
        self._wavelets, self._steps = np.zeros(most, np.int32), np.zeros(most * TILE, np.int8)
        self._mean, self._scale = np.zeros((2, most), np.float32)
        self._tiles: list[PackedRows] = []

    def add(self, rows: Rows, wanted: NDArray[np.bool_]) -> float:
        """Pack a tile, of whose rows some are wanted (64,); returns the share of energy kept."""
        while True:
            args = (self._depth, self._scratch, self._ids, self._values, self._starts)
            if project(*rows, *args) >= 0:
                break
            room = 2 * len(self._ids)
            self._ids, self._values = np.zeros(room, np.int32), np.zeros(room, np.float32)
        count = max(1, int(wanted.sum()))
        ray_noise(*rows, count, self._chance, self._depth, self._landed)
        length = np.zeros((1, len(STEPS)), np.int32)
        n, size, kept = pack(
            self._ids, self._values, self._starts, wanted, self._importance, self._landed.variance,
            self._coefficients, self._scratch, length[0], self._wavelets, self._mean, self._scale,
            self._steps,
        )  # fmt: skip
        forget_noise(rows.cluster, rows.first[-1], self._landed)
        ids, mean, scale = self._wavelets[:n], self._mean[:n], self._scale[: length[0, :-1].sum()]
        steps = self._steps[:size].copy()
        self._tiles.append(PackedRows(length, ids.copy(), mean.copy(), scale.copy(), steps))
        return float(kept)

    def packed(self) -> PackedRows:
        """All tiles."""
        return PackedRows(*(np.concatenate(parts) for parts in zip(*self._tiles, strict=True)))


@njit(cache=True, nogil=True)
def pack(
    ids, values, starts, wanted, importance, noise, coefficients, scratch, out_length, out_ids,
    out_mean, out_scale, out_steps,
):  # fmt: skip
    """Choose one tile's wavelets and quantise them.

    ids, values, starts as from `rows.project`, for 64 rows; wanted (64,) bool, whether a row stands
    for a point; importance (n_g,) float32 weighs the coefficients of one wavelet against those of
    others, noise (c,) is the variance by chance of those of every cluster. out_length (4,),
    out_ids, out_mean, out_scale (k,), out_steps (64 k,) get the tile as in
    `PackedRows`, with k wavelets at most. Returns the number of wavelets, the number of steps, and
    the share of the weighted energy that they keep.
    """
    scratch = borrow(scratch)
    mine, found = _find_wavelets(ids, values, starts, scratch)
    price = PRICE * _price(ids, values, starts, wanted, importance, coefficients)

    # The candidates: as many as there is room for, the greatest energy first.
    energy = np.zeros(found)
    for j in range(found):
        energy[j] = scratch.energy[mine[j]] * importance[mine[j]] ** 2
    candidates = np.argsort(-energy, kind="mergesort")[: out_ids.shape[0]]
    rest = energy.sum() - energy[candidates].sum()
    for j in range(found):
        scratch.slot[mine[j]] = -1
        scratch.energy[mine[j]] = 0.0
    for c in range(len(candidates)):
        scratch.slot[mine[candidates[c]]] = c

    # What they are over the tile. Rows that nobody wants are made like the others.
    table = np.zeros((TILE, len(candidates)), np.float32)
    for b in range(TILE):
        for q in range(starts[b], starts[b + 1]):
            if scratch.slot[ids[q]] >= 0:
                table[b, scratch.slot[ids[q]]] = values[q]
    for c in range(len(candidates)):
        scratch.slot[mine[candidates[c]]] = -1
    _fill_unwanted(table, wanted)
    table = transform(table)

    # Choose how much of each.
    weight, chance = np.zeros((2, len(candidates)))
    for c in range(len(candidates)):
        weight[c] = importance[mine[candidates[c]]] ** 2
        chance[c] = noise[cluster_of(mine[candidates[c]])]
    width, kept = _choose_widths(table, weight, chance, price, rest)
    count = size = 0
    for k in range(len(STEPS)):
        out_length[k] = 0
        for c in range(len(candidates)):
            if width[c] == max(1, STEPS[k]):
                out_ids[count] = mine[candidates[c]]
                out_mean[count] = table[0, c] / UNIT_OF[0]
                if STEPS[k] > 0:
                    out_scale[count] = _quantise(table[:, c], out_steps[size : size + STEPS[k]])
                out_length[k] += 1
                count += 1
                size += STEPS[k]
    return count, size, kept


@njit
def _find_wavelets(ids, values, starts, scratch):
    """(wavelets, their number); sums the energy of each in scratch."""
    found = 0
    mine = scratch.queue
    for q in range(starts[TILE]):
        w = ids[q]
        if scratch.slot[w] == -1:
            scratch.slot[w] = -2
            mine[found] = w
            found += 1
        scratch.energy[w] += values[q] * values[q]
    return mine, found


@njit
def _price(ids, values, starts, wanted, importance, coefficients):
    """Energy that a byte must be worth: the least that rows with a list of their own would keep."""
    total = 0.0
    for b in range(TILE):
        n = starts[b + 1] - starts[b]
        if n <= coefficients:
            continue
        own = np.zeros(n)
        for j in range(n):
            q = starts[b] + j
            own[j] = (values[q] * importance[ids[q]]) ** 2
        total += np.partition(own, n - coefficients)[n - coefficients]
    return total / max(1, wanted.sum())


@njit
def _fill_unwanted(table, wanted):
    mean = np.zeros(table.shape[1], np.float32)
    for b in range(TILE):
        if wanted[b]:
            mean += table[b]
    mean /= np.float32(max(1, wanted.sum()))
    for b in range(TILE):
        if not wanted[b]:
            table[b] = mean


@njit
def _choose_widths(table, weight, noise, price, rest):
    """(coefficients to keep of each column (k,), share of the energy that they hold).

    table (64, k) are coefficients over the tile, noise (k,) the variance of each by chance, weight
    (k,) factors on their energy; `rest` is the energy of what is not in the table.
    """
    width = np.zeros(table.shape[1], np.int64)
    kept, total = 0.0, rest
    for c in range(table.shape[1]):
        # The best of the widths: what it spares, less the price of its bytes.
        best = held = cost = energy = 0.0
        begin, end = 0, 1
        for k in range(len(COSTS)):
            for q in range(begin, end):
                energy += weight[c] * table[q, c] ** 2
            cost += COSTS[k]
            worth = energy - 2.0 * end * noise[c] * weight[c] - price * cost
            if worth > best:
                best, held, width[c] = worth, energy, end
            begin, end = end, 4 * end
        kept += held
        total += energy
    return width, (kept / total if total > 0.0 else 1.0)


@njit
def _quantise(coefficients, steps):
    """Fill the steps (n,) but the first; returns the value of one."""
    largest = 0.0
    for q in range(1, steps.shape[0]):
        largest = max(largest, abs(coefficients[q]) / UNIT_OF[q])
    step = largest / 127.0
    steps[:] = 0
    if step > 0.0:
        for q in range(1, steps.shape[0]):
            steps[q] = int(np.rint(coefficients[q] / UNIT_OF[q] / step))
    return step
