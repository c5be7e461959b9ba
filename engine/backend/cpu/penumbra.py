"""Soft shadows from few rays: neighbours ask different points of a light and share the answers.

Interleaved sampling (Keller and Heidrich 2001): each pixel of a block of 2 x 2 has a quarter of the
light's sample points, so a filter over all four gives what all the points would give everywhere,
for a quarter of the rays.
"""

from __future__ import annotations

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, length, sub, vec

RIGHT, DOWN = 1, 2
SAME_NORMAL = 0.95
OFF_PLANE = 0.2  # of the distance of two neighbours, at most


def alike_neighbours(
    position: NDArray[np.float32],
    normal: NDArray[np.float32],
    obj: NDArray[np.int32],
    matt: NDArray[np.bool_],
    width: int,
) -> NDArray[np.uint8]:
    """(n,) uint8: whether a pixel lies on one smooth surface with the one to its right and below.

    That is of one object, and matt or glossy in both.

    The sum of RIGHT and DOWN; arrays as in `fixed_view.frame_buffer.Points`, of a picture so wide.
    """
    out = np.zeros(len(obj), np.uint8)
    for_ranges(_find_alike, len(obj), position, normal, obj, matt, width, out)
    return out


@njit(cache=True, nogil=True)
def _find_alike(start, stop, position, normal, obj, matt, width, out):
    for i in range(start, stop):
        if (i + 1) % width and _alike(i, i + 1, position, normal, obj, matt):
            out[i] |= RIGHT
        if i + width < obj.shape[0] and _alike(i, i + width, position, normal, obj, matt):
            out[i] |= DOWN


@njit
def _alike(i, q, position, normal, obj, matt):
    n, m = vec(normal, i), vec(normal, q)
    if obj[i] < 0 or obj[i] != obj[q] or matt[i] != matt[q] or dot(n, m) < SAME_NORMAL:
        return False
    way = sub(vec(position, q), vec(position, i))
    return max(abs(dot(way, n)), abs(dot(way, m))) <= OFF_PLANE * length(way)


def smooth_penumbrae(
    radiance: NDArray[np.float32], row: NDArray[np.float32], alike: NDArray[np.uint8], width: int
) -> NDArray[np.float32]:
    """Radiance (n, 3) of a picture so wide, averaged over the 3 x 3 around each pixel, (n, 3).

    The weights are those of a tent, 1 2 1 each way, by which every pixel of a block of 2 x 2 counts
    the same. Averaged is what arrives, not what is reflected, so that textures stay sharp; and on
    one surface alone: a neighbour on another is replaced by the one opposite, which has the same
    place in its block. row (n, ROW) are BRDF parameters, alike (n,) is from `alike_neighbours`.
    """
    across, out = np.zeros_like(radiance), np.zeros_like(radiance)
    for_ranges(_smooth_across, len(radiance), radiance, row, alike, across)
    for_ranges(_smooth_down, len(radiance), across, row, alike, width, out)
    return out


@njit(cache=True, nogil=True)
def _smooth_across(start, stop, radiance, row, alike, out):
    for i in range(start, stop):
        left, right = _pair(alike, i, 1, RIGHT)
        for c in range(3):
            here = _arriving(radiance, row, i, c)
            there = _arriving(radiance, row, left, c) + _arriving(radiance, row, right, c)
            out[i, c] = 0.5 * here + 0.25 * there


@njit(cache=True, nogil=True)
def _smooth_down(start, stop, arriving, row, alike, width, out):
    for i in range(start, stop):
        above, below = _pair(alike, i, width, DOWN)
        for c in range(3):
            mean = 0.5 * arriving[i, c] + 0.25 * (arriving[above, c] + arriving[below, c])
            out[i, c] = mean * (row[i, c] + row[i, 3 + c])


def mean_seen(
    seen: NDArray[np.float32],
    pixel: NDArray[np.int32],
    around: NDArray[np.int32],
    alike: NDArray[np.uint8],
    width: int,
    reach: int,
) -> NDArray[np.float32]:
    """(m,) float32: the part of a light that is seen around pixels (m,) of a picture so wide.

    The weights are those of a tent, which falls to 0 `reach` pixels away each way, by which every
    pixel of a block of reach x reach counts the same. seen (n, 2) is from `soft.look`; pixels that
    the light is under the horizon of have no weight. Outside of `around` all see the same.
    """
    across, out = seen.copy(), np.zeros(len(pixel), np.float32)
    for_ranges(_seen_across, len(around), around, seen, alike, reach, across)
    for_ranges(_seen_down, len(pixel), pixel, across, alike, width, reach, out)
    return out


@njit(cache=True, nogil=True)
def _seen_across(start, stop, pixel, seen, alike, reach, out):
    for j in range(start, stop):
        i = pixel[j]
        out[i, 0], out[i, 1] = _sums(seen, alike, i, 1, RIGHT, reach)


@njit(cache=True, nogil=True)
def _seen_down(start, stop, pixel, across, alike, width, reach, out):
    for j in range(start, stop):
        came, sent = _sums(across, alike, pixel[j], width, DOWN, reach)
        out[j] = came / sent if sent > 0.0 else 0.0


@njit
def _sums(seen, alike, i, step, way, reach):
    """Sums over a pixel and those up to `reach` steps away both ways, while they are alike."""
    came, sent = reach * np.float64(seen[i, 0]), reach * np.float64(seen[i, 1])
    before = behind = i
    for weight in range(reach - 1, 0, -1):
        if before >= step and alike[before - step] & way:
            before -= step
            came, sent = came + weight * seen[before, 0], sent + weight * seen[before, 1]
        else:
            before = -1
        if behind >= 0 and alike[behind] & way:
            behind += step
            came, sent = came + weight * seen[behind, 0], sent + weight * seen[behind, 1]
        else:
            behind = -1
    return came / (reach * reach), sent / (reach * reach)


def changes_fast(
    part: NDArray[np.float32],
    pixel: NDArray[np.int32],
    alike: NDArray[np.uint8],
    width: int,
    steepest: float,
) -> NDArray[np.bool_]:
    """(m,) bool: whether what pixels (m,) see of a light changes by more than `steepest` a pixel.

    So it may also where one of the four neighbours is not alike. part (n,) float32 is what each
    sees.
    """
    out = np.zeros(len(pixel), np.bool_)
    for_ranges(_find_steep, len(pixel), part, pixel, alike, width, steepest, out)
    return out


@njit(cache=True, nogil=True)
def _find_steep(start, stop, part, pixel, alike, width, steepest, out):
    for j in range(start, stop):
        i = pixel[j]
        n, column = part.shape[0], i % width
        across = abs(part[i + min(2, width - 1 - column)] - part[i - min(2, column)])
        below = i + 2 * width if i + 2 * width < n else i
        down = abs(part[below] - part[i - 2 * width if i >= 2 * width else i])
        smooth = alike[i] == RIGHT | DOWN and column > 0 and i >= width
        smooth = smooth and alike[i - 1] & RIGHT and alike[i - width] & DOWN
        out[j] = not smooth or max(across, down) > 4.0 * steepest


@njit
def _pair(alike, i, step, way):
    """The neighbours of i before and behind; one for the other, or i, where they are not alike."""
    before = i - step if i >= step and alike[i - step] & way else i
    behind = i + step if alike[i] & way else before
    return (before if before != i else behind), behind


@njit
def _arriving(radiance, row, i, c):
    """What arrives, as far as the reflected radiance and the BRDF's two colours tell."""
    reflectance = row[i, c] + row[i, 3 + c]
    return radiance[i, c] / reflectance if reflectance > 0.0 else 0.0
