"""Encode a table of a BRDF: transform, quantise, leave out tiles (Claustres et al. 2007, §4, §5).

Coefficients of one node are one slice of the paper's 3-D texture, over the plane of incident
directions. The paper leaves out whole slices; where a lobe moves over the plane, most of a slice
is next to nothing but little of it all, so we cut slices into tiles and leave out those, the
lightest first, until the error or the size that is asked for is met. Two errors count: the mean
relative one over all samples (§6.2), most of which are far from any highlight, and the part of all
reflected light that is in a wrong place. A tile weighs what its coefficients mean to either.

Coefficients get 8 bits, in even steps up to the largest of their tile, so that they may be
interpolated as they are. With a floor of εμ under all values, μ their mean, ratios are bounded
(§5.1). Where all channels are one but for a factor, they are kept as one.
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
SCALES = 255  # of a tile, the largest
GREY = 1e-5  # by which channels may differ in their ratios and still be one
NOTHING = 1e-6  # of a coefficient: less is rounding
MOST_TILES = 0xFFFF  # that two octets can tell apart from each other and from none
HALVINGS = 12


@dataclass(frozen=True)
class Target:
    """What an encoding is to reach: the first of them that is given.

    bytes  at most so many
    error  at most so much of either error of `Encoded`
    floor  ε, part of the mean value of a channel below which values blur into each other
    """

    bytes: int | None = None
    error: float | None = 0.01
    floor: float = 1e-3


DEFAULT = Target()


@dataclass(frozen=True, eq=False)
class Encoded:
    """An encoded BRDF.

    data   (n,) uint8, see `layout`
    grid   what it was sampled on
    error  mean relative error over all samples and channels, against the table that was encoded
    worst  99th percentile of the same
    light  part of all light, from everywhere, that is reflected where it should not be
    kept   part of the tiles that is kept
    """

    data: NDArray[np.uint8]
    grid: Grid
    error: float
    worst: float
    light: float
    kept: float

    @property
    def bytes(self) -> int:
        """Size of all of it."""
        return len(self.data)

    @property
    def tiles(self) -> int:
        """Tiles that are stored; those that are equal are once."""
        views = layout.block(self.data)
        first, last = views.header[layout.FIRST_ROW], views.header[layout.FIRST_TILE] // 2
        return int(views.words[first:last].max(initial=0))


def encode(values: NDArray[np.floating], grid: Grid, target: Target = DEFAULT) -> Encoded:
    """Encode values (θ, φ, down, across, 3) in sr⁻¹, not negative.

    Raises InputError where the size that is asked for is less than what cannot be left out.
    """
    if not 1e-9 <= target.floor <= 1:
        raise InputError(f"the floor is {target.floor}, not from 1e-9 to 1", field="floor")
    channels = values.mean(axis=(0, 1, 2, 3), dtype=np.float64)
    floor = target.floor * np.where(channels > 0, channels, channels.mean() or 1.0)
    mean, ratios, parts = analyse(values + floor, grid)
    arriving = grid.incident_weights[..., None]
    bright = parts * mean * arriving / (mean * arriving).sum()
    if np.abs(ratios - ratios[..., :1]).max() <= GREY:
        ratios = ratios[..., :1]
    tiles = _cut(ratios)
    order, heavy = _by_weight(tiles, _cut(bright))
    ranges, scales, codes = _quantised(tiles)
    coarse = codes * _steps(ranges, scales)

    def kept(count: int) -> NDArray[np.bool_]:
        mask = np.zeros(scales.shape, np.bool_)
        mask.reshape(-1)[order[:count]] = True
        return mask

    share = np.multiply.outer(*grid.weights)[..., None, None, None] * arriving
    all_light = float((values * share).sum())

    def found(count: int) -> tuple[float, float, Array]:
        """Both errors, and the relative one of each sample."""
        some = np.where(kept(count)[..., None, None, None], coarse, 0)
        value = synthesise(mean, _joined(some, ratios.shape), grid)
        off = np.abs(np.maximum(value - floor, 0) - values)
        relative = off / (values + floor)
        light = float((off * share).sum()) / (2 * all_light) if all_light > 0 else 0.0
        return float(relative.mean()), light, relative

    count = min(heavy, MOST_TILES)
    if target.bytes is not None:
        most, fixed = (
            target.bytes,
            len(_laid_out(grid, floor, mean, ranges, scales, codes, kept(0))),
        )
        if fixed > most:
            raise InputError(f"the least is {fixed} bytes, not {most}", field="bytes")
        row, tile = 2 * kept(0)[0].size, 1 + codes[0, 0, 0].nbytes

        def is_beyond(k: int) -> bool:
            rows = int(kept(k).any(axis=(1, 2)).sum())
            return fixed + rows * row + k * tile > most

        while is_beyond(count):
            count = min(count - 1, _least(count, is_beyond) - 1)
    elif target.error is not None:
        bound = target.error
        count = _least(count, lambda k: max(found(k)[:2]) <= bound)
    data = _laid_out(grid, floor, mean, ranges, scales, codes, kept(count))
    error, light, relative = found(count)
    worst = float(np.quantile(relative, 0.99))
    return Encoded(data, grid, error, worst, light, count / len(order))


def _depths(nodes: int) -> NDArray[np.int64]:
    """(nodes, 1, 1): the depth of each node."""
    return np.frexp(np.arange(1, nodes + 1))[1][:, None, None] - 1


def _quantised(tiles: Array) -> tuple[Array, NDArray[np.uint8], NDArray[np.int8]]:
    """(ranges (depth,), scales by tile, codes): a coefficient is its code times `_steps`."""
    depths, largest = _depths(len(tiles))[:, :, 0], np.abs(tiles).max(axis=(3, 4, 5))
    ranges = np.array([largest[depths[:, 0] == k].max() for k in range(depths.max() + 1)])
    ranges = np.where(ranges > NOTHING, ranges, 1.0)
    scales = np.ceil(SCALES * np.sqrt(largest / ranges[depths][..., None]))
    scales = np.clip(scales, 1, SCALES).astype(np.uint8)
    codes = np.rint(tiles / _steps(ranges, scales)).astype(np.int8)
    return ranges, scales, codes


def _steps(ranges: Array, scales: NDArray[np.uint8]) -> Array:
    """What one step of a code is, by tile: of the range of its depth the square of the scale."""
    part = (scales / SCALES) ** 2 / STEPS
    return (ranges[_depths(len(scales))] * part)[..., None, None, None]


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


def _by_weight(tiles: Array, bright: Array) -> tuple[NDArray[np.int64], int]:
    """(tiles by number, the heaviest first; how many hold anything).

    Half a coefficient is what the logarithms of the leaves below it are off without. `bright` is
    what each node reflects of all light, for each incident direction.
    """
    leaves = 2.0 ** -_depths(len(tiles))[..., None, None, None]
    samples = tiles[0].size / tiles.shape[-1]
    both = leaves / samples + bright.mean(axis=-1, keepdims=True)
    weight = (np.abs(tiles) * both).sum(axis=(3, 4, 5))
    heavy = np.abs(tiles).max(axis=(3, 4, 5)) > NOTHING
    weight *= heavy
    return np.argsort(-weight.ravel(), kind="stable"), int(heavy.sum())


def _least(most: int, holds: Callable[[int], bool]) -> int:
    """A count up to `most` from which on something holds, about the least; `most` if none is."""
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
    scales: NDArray[np.uint8],
    codes: NDArray[np.int8],
    kept: NDArray[np.bool_],
) -> NDArray[np.uint8]:
    """The block. Tiles that are equal are stored once."""
    theta, phi = grid.weights
    splits = layout.schedule(grid.theta_bits, grid.phi_bits)
    parts: list[tuple[int, NDArray[Any]]] = [
        (layout.ROOT, np.log(mean)),
        (layout.RANGES, ranges / (STEPS * SCALES**2)),
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
    some = (codes[kept] + np.int16(128)).astype(np.uint8)
    some = some.reshape(len(some), int(np.prod(codes.shape[3:])))
    some = np.concatenate([scales[kept][:, None], some], axis=1)
    stored, which = np.unique(some, axis=0, return_inverse=True)
    numbers = np.zeros(kept.shape, np.uint16)
    numbers[kept] = which.ravel() + 1
    filled = kept.any(axis=(1, 2))
    filling = numbers[filled].reshape(-1, kept[0].size)
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


def _heap(weights: Array, *, ratios: bool) -> Array:
    """Of one angle's cells (n,): for each node k from 1 on, w_2k+1 / w_2k, or 1 / w_k."""
    level, levels = weights, [weights]
    while len(level) > 1:
        level = level[0::2] + level[1::2]
        levels.append(level)
    whole = np.concatenate([[1.0], *levels[::-1]])
    return whole[3::2] / whole[2::2] if ratios else 1 / whole
