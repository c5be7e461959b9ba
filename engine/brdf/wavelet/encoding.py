"""Encode a table of a BRDF: transform, quantise, leave out tiles (Claustres et al. 2007, §4, §5).

Coefficients of one node are one slice of the paper's 3-D texture, over the plane of incident
directions. The paper leaves out whole slices; where a lobe moves over the plane, most of a slice
is next to nothing but little of it all, so we cut slices into tiles and leave out those. Each tile
has its own weight, the sum of its coefficients times the leaves that they bear on, and the lightest
go first until the error or the size that is asked for is met.

Coefficients get 8 bits, even steps up to the largest of their split and channel. So a texture unit
may interpolate them. With a floor of εμ under all values, μ their mean, ratios are bounded (§5.1).
Where all channels are one but for a factor, they are kept as one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.wavelet import layout
from engine.brdf.wavelet.analysis import Array, Grid, analyse, synthesise
from engine.brdf.wavelet.layout import TILE
from engine.errors import InputError

STEPS = 127  # of a coefficient, to either side of 0
GREY = 1e-5  # by which channels may differ in their ratios and still be one
NOTHING = 1e-6  # of a coefficient: less is rounding
HALVINGS = 12


@dataclass(frozen=True)
class Target:
    """What an encoding is to reach: the first of them that is given.

    bytes  at most so many
    error  mean relative error over all samples, at most
    floor  ε, part of the mean value of a channel below which values blur into each other
    """

    bytes: int | None = None
    error: float | None = 0.01
    floor: float = 1e-3


@dataclass(frozen=True, eq=False)
class Encoded:
    """An encoded BRDF.

    data   (n,) uint8, see `layout`
    grid   what it was sampled on
    error  mean relative error over all samples and channels, against the table that was encoded
    worst  99th percentile of the same
    kept   part of the tiles that is kept
    """

    data: NDArray[np.uint8]
    grid: Grid
    error: float
    worst: float
    kept: float

    @property
    def bytes(self) -> int:
        """Size of all of it."""
        return len(self.data)


def encode(values: NDArray[np.floating], grid: Grid, target: Target | None = None) -> Encoded:
    """Encode values (θ, φ, down, across, 3) in sr⁻¹, not negative.

    Raises InputError where the size that is asked for is less than what cannot be left out.
    """
    target = target or Target()
    if not 1e-9 <= target.floor <= 1:
        raise InputError(f"the floor is {target.floor}, not from 1e-9 to 1", field="floor")
    channels = values.mean(axis=(0, 1, 2, 3), dtype=np.float64)
    floor = target.floor * np.where(channels > 0, channels, channels.mean() or 1.0)
    mean, ratios = analyse(values + floor, grid)
    if np.abs(ratios - ratios[..., :1]).max() <= GREY:
        ratios = ratios[..., :1]
    ranges = _ranges(ratios)
    codes = np.rint(ratios / ranges[_depths(len(ratios))] * STEPS).astype(np.int8)
    tiles = _cut(codes)
    order, heavy = _by_weight(_cut(ratios))

    def kept(count: int) -> NDArray[np.bool_]:
        mask = np.zeros(tiles.shape[:3], np.bool_)
        mask.reshape(-1)[order[:count]] = True
        return mask

    def errors(count: int) -> Array:
        some = _joined(np.where(kept(count)[..., None, None, None], tiles, 0), codes.shape)
        coarse = some * ranges[_depths(len(ratios))] / STEPS
        found = np.maximum(synthesise(mean, coarse, grid) - floor, 0)
        return np.abs(found - values) / (values + floor)

    count = heavy
    if target.bytes is not None:
        fixed = len(_laid_out(grid, floor, mean, ranges, tiles, kept(0)))
        if fixed > target.bytes:
            raise InputError(f"the least is {fixed} bytes, not {target.bytes}", field="bytes")
        count = min(count, (target.bytes - fixed) // tiles[0, 0, 0].nbytes)
    elif target.error is not None:
        bound = target.error
        count = _least(count, lambda k: float(errors(k).mean()) <= bound)
    off = errors(count)
    data = _laid_out(grid, floor, mean, ranges, tiles, kept(count))
    return Encoded(data, grid, float(off.mean()), float(np.quantile(off, 0.99)), count / len(order))


def _depths(nodes: int) -> NDArray[np.int64]:
    """(nodes, 1, 1): the depth of each node."""
    return np.frexp(np.arange(1, nodes + 1))[1][:, None, None] - 1


def _ranges(ratios: Array) -> Array:
    """(depth, channels): the largest of either sign; 1 where there is nothing."""
    depths = _depths(len(ratios)).ravel()
    largest = np.abs(ratios).max(axis=(1, 2))
    found = np.stack([largest[depths == k].max(axis=0) for k in range(depths[-1] + 1)])
    return np.where(found > NOTHING, found, 1.0)


def _cut(slices: NDArray[Any]) -> NDArray[Any]:
    """(nodes, down, across, rows, TILE + 1, channels): tiles of slices, with both their ends."""
    down, across = slices.shape[1:3]
    tall, wide = -(-down // TILE) if down > 1 else 1, -(-across // TILE)
    high = TILE if down > 1 else 0
    padded = np.pad(
        slices,
        ((0, 0), (0, tall * high + 1 - down), (0, wide * TILE + 1 - across), (0, 0)),
        mode="edge",
    )
    rows = (np.arange(tall) * high)[:, None] + np.arange(high + 1)
    columns = (np.arange(wide) * TILE)[:, None] + np.arange(TILE + 1)
    return padded[:, rows[:, None, :, None], columns[None, :, None, :]]


def _joined(tiles: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """The inverse of `_cut`."""
    n, tall, _, rows, columns, channels = tiles.shape
    high = max(1, rows - 1)
    whole = tiles[:, :, :, :high, : columns - 1].transpose(0, 1, 3, 2, 4, 5)
    return whole.reshape(n, tall * high, -1, channels)[:, : shape[1], : shape[2]]


def _by_weight(tiles: Array) -> tuple[NDArray[np.int64], int]:
    """(tiles by number, the heaviest first; how many weigh anything).

    Half a tile's coefficient is what the logarithms of the leaves below it are off without.
    """
    leaves = 2.0 ** -_depths(len(tiles))
    weight = np.abs(tiles).sum(axis=(3, 4)).mean(axis=-1) * leaves
    heavy = np.abs(tiles).max(axis=(3, 4, 5)) > NOTHING
    weight *= heavy
    return np.argsort(-weight.ravel(), kind="stable"), int(heavy.sum())


def _least(most: int, holds: Callable[[int], bool]) -> int:
    """The least count up to `most` from which on something holds; `most` where it never does."""
    low, high = 0, most
    for _ in range(HALVINGS):
        if high - low <= 1:
            break
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def _laid_out(
    grid: Grid,
    floor: Array,
    mean: Array,
    ranges: Array,
    tiles: NDArray[np.int8],
    kept: NDArray[np.bool_],
) -> NDArray[np.uint8]:
    """The block. Tiles that are equal are stored once."""
    theta, phi = grid.weights
    splits = layout.schedule(grid.theta_bits, grid.phi_bits)
    # Kernels take four channels at a time.
    repeats = [1, 1, 2] if ranges.shape[1] == 3 else [4]
    parts: list[tuple[int, NDArray[Any]]] = [
        (layout.ROOT, np.log(mean)),
        (layout.RANGES, np.repeat(ranges / STEPS, repeats, axis=1)),
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
    some = tiles[kept]
    shape = some.shape[1:]
    stored, which = np.unique(
        some.reshape(len(some), int(np.prod(shape))), axis=0, return_inverse=True
    )
    if len(stored) > 0xFFFE:
        raise InputError(f"{len(stored)} tiles are more than {0xFFFE}", field="bytes")
    numbers = np.zeros(kept.shape, np.uint16)
    numbers[kept] = which.ravel() + 1
    header[layout.MAP] = 2 * size
    header[layout.FIRST_TILE] = 4 * size + numbers.nbytes
    header[layout.SYMMETRY], header[layout.THETA_BITS] = grid.symmetry, grid.theta_bits
    header[layout.PHI_BITS], header[layout.ACROSS] = grid.phi_bits, grid.across
    header[layout.DOWN], header[layout.CHANNELS] = grid.down, tiles.shape[-1]
    octets = (stored.reshape(len(stored), *shape) + np.int16(128)).astype(np.uint8)
    data = [*(f.view(np.uint8) for f in floats), numbers.ravel().view(np.uint8), octets.ravel()]
    # Whole words, and room to read four octets at the last.
    room = -sum(map(len, data)) % 4 + 4
    return np.concatenate([*data, np.zeros(room, np.uint8)])


def _heap(weights: Array, *, ratios: bool) -> Array:
    """Of one angle's cells (n,): for each node k from 1 on, w_2k+1 / w_2k, or 1 / w_k."""
    level, levels = weights, [weights]
    while len(level) > 1:
        level = level[0::2] + level[1::2]
        levels.append(level)
    whole = np.concatenate([[1.0], *levels[::-1]])
    return whole[3::2] / whole[2::2] if ratios else 1 / whole
