"""How far off a picture is where facets are smaller than pixels, and a pixel shows one of them.

A pixel should show the mean of its facets. Where normals go to and fro from pixel to pixel, its
neighbours show what it might as well have shown, so how far it is from their mean tells how far it
is from its own. Of the four blocks of 2 x 2 pixels around it the one that it is nearest to counts:
beside an outline, or where a shadow ends, one of them lies on its side.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.methods.fixed_view.frame_buffer import Points
from engine.numerics.parallel import for_ranges

# The variance of normal noise over the mean square of the least distance from a block's mean.
LEAST = 3.27


def scatter(points: Points, image: NDArray[np.float32]) -> float:
    """The relative L2 error of a picture, (h, w, 3), by pixels that show one facet of many.

    points are its pixels row by row.
    """
    height, width = image.shape[:2]
    squares = np.zeros((height, width), np.float32)
    normal = points.normal.reshape(height, width, 3)
    obj = points.object.reshape(height, width)
    for_ranges(_scatter, height - 2, normal, obj, image, squares, grain=32)
    off = float(squares.sum(dtype=np.float64))
    if off == 0:
        return 0.0
    return math.sqrt(LEAST * off / float(np.sum(np.square(image), dtype=np.float64)))


@njit(cache=True, nogil=True)
def _scatter(start, stop, normal, obj, image, squares):
    for y in range(start + 1, stop + 1):
        for x in range(1, image.shape[1] - 1):
            if _is_rough(normal, obj, y, x):
                least = np.float32(np.inf)
                for dy, dx in ((-1, -1), (-1, 1), (1, -1), (1, 1)):
                    least = min(least, _from_mean(image, y, x, y + dy, x + dx))
                squares[y, x] = least


@njit
def _from_mean(image, y, x, v, u):
    """The square of the distance of pixel (y, x) from the mean of the block that ends at (v, u)."""
    off = np.float32(0)
    for c in range(3):
        others = image[v, x, c] + image[y, u, c] + image[v, u, c]
        off += (np.float32(0.25) * (np.float32(3) * image[y, x, c] - others)) ** 2
    return off


@njit
def _is_rough(normal, obj, y, x):
    """Whether normals bend more at a pixel than they turn across it, on an object that goes on."""
    if obj[y, x] < 0:
        return False
    for v, u in ((y - 1, x), (y + 1, x), (y, x - 1), (y, x + 1)):
        if obj[v, u] != obj[y, x]:
            return False
    bend, turn = np.float32(0), np.float32(0)
    for c in range(3):
        twice = np.float32(2) * normal[y, x, c]
        bend += (twice - normal[y - 1, x, c] - normal[y + 1, x, c]) ** 2
        bend += (twice - normal[y, x - 1, c] - normal[y, x + 1, c]) ** 2
        turn += (normal[y + 1, x, c] - normal[y - 1, x, c]) ** 2
        turn += (normal[y, x + 1, c] - normal[y, x - 1, c]) ** 2
    return bend > turn
