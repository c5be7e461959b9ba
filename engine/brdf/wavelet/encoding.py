"""Encode a table of a BRDF: transform, cut, leave out, lay out (Claustres et al. 2007, §4, §5).

Tiles of coefficients are left out, the lightest first, until the error or the size that is asked
for is met. Two errors count: the mean relative one over all samples (§6.2), most of which are far
from any highlight, and the part of all reflected light that is in a wrong place.

With a floor of εμ under all values, μ their mean, ratios are bounded (§5.1). Where all channels are
one but for a factor, they are kept as one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from engine.brdf.wavelet import layout
from engine.brdf.wavelet.analysis import Grid, analyse, synthesise
from engine.brdf.wavelet.errors import Errors, errors_of, floors
from engine.brdf.wavelet.packing import bytes_of_tiles, packed
from engine.brdf.wavelet.tiles import Tiles, tiles_of
from engine.errors import InputError

GREY = 1e-5  # by which channels may differ in their ratios and still be one
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
    floor = floors(values, target.floor)
    mean, ratios, parts = analyse(values + floor, grid)
    arriving = grid.incident_weights[..., None]
    bright = parts * mean * arriving / (mean * arriving).sum()
    if np.abs(ratios - ratios[..., :1]).max() <= GREY:
        ratios = ratios[..., :1]
    tiles = tiles_of(ratios, bright)

    def errors(count: int) -> Errors:
        found = synthesise(mean, tiles.ratios(count), grid)
        return errors_of(np.maximum(found - floor, 0), values, grid, floor)

    count = min(tiles.heavy, MOST_TILES)
    if target.bytes is not None:
        room = target.bytes - len(packed(grid, floor, mean, tiles, 0))
        if room < 0:
            least = target.bytes - room
            raise InputError(f"the least is {least} bytes, not {target.bytes}", field="bytes")
        count = _fitting(tiles, count, room)
    elif target.error is not None:
        count = _good_enough(errors, count, target.error)
    found = errors(count)
    return Encoded(
        packed(grid, floor, mean, tiles, count),
        grid, found.mean, found.p99, found.light, count / len(tiles.order),
    )  # fmt: skip


def _good_enough(errors: Callable[[int], Errors], most: int, bound: float) -> int:
    """About the least number of tiles, up to `most`, that both errors are within `bound` with."""

    def holds(count: int) -> bool:
        found = errors(count)
        return found.light <= bound and found.mean <= bound

    return _least(most, holds)


def _fitting(tiles: Tiles, most: int, room: int) -> int:
    """About the largest number of tiles, up to `most`, that fit into so many bytes."""

    def is_beyond(count: int) -> bool:
        return bytes_of_tiles(tiles, count) > room

    while is_beyond(most):
        most = min(most - 1, _least(most, is_beyond) - 1)
    return most


def _least(most: int, holds: Callable[[int], bool]) -> int:
    """A count up to `most` from which on something holds, about the least; `most` if none is."""
    low, high = 0, most
    for _ in range(HALVINGS):
        if high - low <= 1:
            break
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
