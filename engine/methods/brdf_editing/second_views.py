"""Which views of gather samples the rays of pixels look from: their tables need no others.

Of the eighty views of a sample most are never looked up, as what sees it lies in few directions.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.brdf_editing.arriving import Arriving, Surface, aim, part_of
from engine.methods.brdf_editing.links import BEYOND
from engine.methods.brdf_editing.patterns import room_for
from engine.methods.brdf_editing.second import view_along
from engine.numerics.borrow import borrow
from engine.numerics.frames import to_world
from engine.numerics.parallel import for_ranges


def views_asked(
    surface: Surface, arriving: Arriving, pixels: NDArray[np.int32]
) -> NDArray[np.bool_]:
    """(n_g, views): those for pixels, and for others whose rays they take."""
    second = arriving.second
    out = np.zeros((len(second.normal), second.cell.max() + 1), np.bool_)
    some = np.union1d(pixels, surface.donor)
    for_ranges(_mark, len(some), surface, arriving, some, out, grain=64)
    return out


@njit(cache=True, nogil=True)
def _mark(begin, end, surface, arriving, pixels, out):
    surface, arriving = borrow(surface), borrow(arriving)
    rays = room_for(arriving.sample.shape[1])
    for q in range(begin, end):
        i = pixels[q]
        _mark_part(surface, arriving, i, i, 0, 1, rays, out)
        if surface.edge[i] >= 0:
            for part in range(4):
                at, link = part_of(surface, i, part)
                _mark_part(surface, arriving, at, link, part, 4, rays, out)


@njit
def _mark_part(surface, arriving, at, link, part, parts, rays, out):
    if surface.material[at] < 0:
        return
    sample = arriving.sample[link]
    count, frame, _ = aim(surface, arriving, at, link, part, parts, rays)
    for q in range(count):
        k = part + q * parts
        if rays.weight[q] > 0.0 and sample[k] != BEYOND:
            d = to_world((rays.x[q], rays.y[q], rays.z[q]), frame[0], frame[1], frame[2])
            out[sample[k], view_along(arriving.second, sample[k], d, k)] = True
