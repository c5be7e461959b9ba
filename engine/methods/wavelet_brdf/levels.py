"""The level of detail of every pixel, §5.4.1.

    distance    l = clamp(log2(α d), 0, N - 1), d from the eye in diagonals of the scene: the paper
                derives α from the bounding volume
    footprint   l = clamp(log2(Δ / (√3 δ)), 0, N - 1), Δ by how much the directions turn from a
                pixel to the next, the root mean square of both axes, δ the angle of a cell: the
                mean over a pixel has a variance of Δ² / 12, means over cells that are bilinear have
                one of δ² / 4

From one pixel to the next a lobe moves by twice as much as the normal does, whatever bends it: the
curve of a surface, a normal map, or triangles that are smaller than pixels. Where the surface ends
beside a pixel its other neighbours tell.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.brdf.measured import LEVEL
from engine.brdf.wavelet.encoding import Encoded
from engine.methods.fixed_view.frame_buffer import Points
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, length, sub, vec

TURN = 2.0 / math.sqrt(3.0)
# From the finest level to the coarsest.
COLOURS = np.array([(0, 0.1, 1), (0, 0.8, 0.8), (0.1, 0.8, 0), (1, 0.8, 0), (1, 0.05, 0)])


def cells_of(codes: tuple[Encoded | None, ...]) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """((m,) levels that each code has, 0 without one; (m,) angles of its cells)."""
    count = np.zeros(len(codes), np.int32)
    angle = np.ones(len(codes), np.float32)
    for m, code in enumerate(codes):
        if code is not None:
            count[m] = min(code.grid.theta_bits, code.grid.phi_bits)
            angle[m] = np.pi * code.grid.extent[0] / code.grid.cells[0]
    return count, angle


def set_by_distance(
    points: Points,
    eye: tuple[float, float, float],
    factor: float,
    codes: tuple[Encoded | None, ...],
) -> None:
    """Write levels into rows; `factor` is α over the diagonal of the scene, 1/m."""
    count, _ = cells_of(codes)
    args = (points.position, points.material, np.array(eye), factor, count, points.row)
    for_ranges(_by_distance, len(points), *args)


@njit(cache=True, nogil=True)
def _by_distance(start, stop, position, material, eye, factor, count, row):
    e = (eye[0], eye[1], eye[2])
    for i in range(start, stop):
        if material[i] >= 0 and count[material[i]] > 0:
            x = factor * length(sub(vec(position, i), e))
            row[i, LEVEL] = _level(x, count[material[i]])


@njit
def _level(ratio, count):
    return min(max(math.log2(ratio), 0.0), count - 1.0) if ratio > 1.0 else 0.0


def set_by_footprint(points: Points, width: int, codes: tuple[Encoded | None, ...]) -> None:
    """The same from neighbours; the points are pixels row by row."""
    count, angle = cells_of(codes)
    args = (points.normal, points.object, points.material, width, count, angle, points.row)
    for_ranges(_by_footprint, len(points), *args)


@njit(cache=True, nogil=True)
def _by_footprint(start, stop, normal, obj, material, width, count, angle, row):
    n = len(material)
    for i in range(start, stop):
        m = material[i]
        if m < 0 or count[m] == 0:
            continue
        turned, axes = 0.0, 0
        for step, before, after in (
            (1, i % width > 0, i % width < width - 1),
            (width, i >= width, i + width < n),
        ):
            most, met = 0.0, 0
            for j, near in ((i - step, before), (i + step, after)):
                if near and obj[j] == obj[i] and material[j] == m:
                    change = sub(vec(normal, j), vec(normal, i))
                    most, met = max(most, dot(change, change)), 1
            turned, axes = turned + most, axes + met
        if axes > 0:
            row[i, LEVEL] = _level(TURN * math.sqrt(turned / axes) / angle[m], count[m])


def copy_from(pixels: Points, points: Points) -> None:
    """Give points the levels of pixels of the same material."""
    same = pixels.material == points.material
    points.row[same, LEVEL] = pixels.row[same, LEVEL]


def at_least(points: Points, level: float, codes: tuple[Encoded | None, ...]) -> None:
    """Make finer levels this one, or the coarsest that a code has."""
    count, _ = cells_of(codes)
    coded = (points.material >= 0) & (count[points.material] > 0)
    most = np.minimum(level, count[points.material[coded]] - 1)
    points.row[coded, LEVEL] = np.maximum(points.row[coded, LEVEL], most)


def picture_of(points: Points, codes: tuple[Encoded | None, ...]) -> NDArray[np.float32]:
    """(n, 3): the levels in false colours, blue where all is shown, black without a code."""
    count, _ = cells_of(codes)
    shown = (points.material >= 0) & (count[points.material] > 0)
    most = max(1, int(count.max(initial=1)) - 1)
    place = points.row[:, LEVEL] / most * (len(COLOURS) - 1)
    every = np.arange(len(COLOURS))
    out = np.stack([np.interp(place, every, COLOURS[:, c]) for c in range(3)], axis=1)
    return np.where(shown[:, None], out, 0).astype(np.float32)
