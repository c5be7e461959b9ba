"""Cube maps in image files, made into latitude-longitude maps once and for all.

Their faces are oriented as in OpenGL (`engine.numerics.cube_map`) and laid out as

          +Y                  +Y
    -X +Z +X -Z            -X +Z +X         +X -X +Y -Y +Z -Z
          -Y                  -Y            from left to right,
                              -Z            or from the top down.

In the upright cross -Z stands on its head, as it does where the cross is folded. The shape of an
image tells which of them it is: 4 to 3, 3 to 4, 6 to 1, 1 to 6.

A column of the new map is a bundle of meridians. Along each of them it is known exactly where it
goes from texel to texel and from row to row, and none of the bundles crosses the border of a column
of texels, which on the faces at the sides is a meridian itself. So only the little between one and
the next is left to a sum: every texel keeps its energy to 0.1 %, and a constant stays one.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.numerics import cube_map
from engine.numerics.parallel import for_ranges

MERIDIANS = 16  # of a bundle, which is as wide as a texel or less

# Row and column of the faces +X -X +Y -Y +Z -Z, by (rows, columns) of the image.
LAYOUTS: dict[tuple[int, int], tuple[tuple[int, int], ...]] = {
    (3, 4): ((1, 2), (1, 0), (0, 1), (2, 1), (1, 1), (1, 3)),
    (4, 3): ((1, 2), (1, 0), (0, 1), (2, 1), (1, 1), (3, 1)),
    (1, 6): tuple((0, k) for k in range(6)),
    (6, 1): tuple((k, 0) for k in range(6)),
}
UPRIGHT_CROSS = (4, 3)


def cube_faces(image: NDArray[np.float32]) -> NDArray[np.float32] | None:
    """The faces (6, n, n, 3) of an image (h, w, 3); None where its shape is that of no layout.

    What a cross has beside its faces is not looked at.
    """
    height, width = image.shape[:2]
    for (rows, columns), cells in LAYOUTS.items():
        n = height // rows
        if (height, width) != (rows * n, columns * n):
            continue
        faces = np.stack([image[i * n : i * n + n, j * n : j * n + n] for i, j in cells])
        if (rows, columns) == UPRIGHT_CROSS:
            faces[5] = faces[5, ::-1, ::-1]
        return faces
    return None


def unfolded(faces: NDArray[np.float32]) -> NDArray[np.float32]:
    """A latitude-longitude map (2 n, 4 n, 3) of the faces (6, n, n, 3) of a cube map."""
    n = faces.shape[1]
    # The middle of a map looks along -z, as a face does; texels' borders are turned to the others.
    border = np.arctan(np.linspace(-1, 1, n + 1)[:-1])
    turns = 0.5 * np.pi * np.arange(-2, 3)[:, None] + border
    column = np.linspace(-np.pi, np.pi, 4 * n + 1)
    within = turns[(turns > -np.pi) & (turns < np.pi)]
    bundle = np.union1d(column, within)
    first = np.searchsorted(bundle, column)
    out = np.zeros((2 * n, 4 * n, 3))
    for_ranges(_unfold, 4 * n, np.ascontiguousarray(faces), bundle, first, out, grain=16)
    level = np.cos(np.linspace(0, np.pi, 2 * n + 1))
    solid = (level[:-1] - level[1:]) * 2 * np.pi / (4 * n)
    return (out / solid[:, None, None]).astype(np.float32)


@njit(cache=True, nogil=True)
def _unfold(start, stop, faces, bundle, first, out):
    """Fill columns of out (2 n, 4 n, 3) with integrals over the solid angle of their pixels.

    Column j has the bundles between bundle[k] and bundle[k + 1], k from first[j] to first[j + 1].
    """
    height = out.shape[0]
    edge = np.cos(np.pi * np.arange(height + 1) / height)
    room = np.zeros(5 * faces.shape[1] + 2)
    for column in range(start, stop):
        for k in range(first[column], first[column + 1]):
            step = (bundle[k + 1] - bundle[k]) / MERIDIANS
            for m in range(MERIDIANS):
                phi = bundle[k] + (m + 0.5) * step
                _follow(math.sin(phi), -math.cos(phi), step, faces, edge, room, out[:, column])


@njit
def _follow(x, z, step, faces, edge, room, out):
    """Add a meridian that is step wide to a column (rows, 3); (x, z) is where it leads to."""
    n = faces.shape[1]
    count = _borders(x, z, n, room)
    room[count : count + edge.shape[0]] = edge
    heights = np.sort(room[: count + edge.shape[0]])
    row = out.shape[0] - 1
    for i in range(heights.shape[0] - 1):
        low, high = heights[i], heights[i + 1]
        y = 0.5 * (low + high)
        while row > 0 and y > edge[row]:
            row -= 1
        r = math.sqrt(max(0.0, 1.0 - y * y))
        face, a, b = cube_map.place((r * x, y, r * z))
        p = min(n - 1, int(0.5 * (a + 1.0) * n))
        q = min(n - 1, int(0.5 * (b + 1.0) * n))
        for c in range(3):
            out[row, c] += step * (high - low) * faces[face, q, p, c]


@njit
def _borders(x, z, n, out):
    """Fill out with the heights at which a meridian goes from texel to texel; returns how many.

    (x, z) is its direction on the horizon.
    """
    steep = max(abs(x), abs(z))  # the faces at the sides reach up to this slope
    count = 0
    for i in range(n + 1):
        e = 2.0 * i / n - 1.0
        # Across the faces at the sides it runs straight down.
        slope = e * steep
        out[count] = slope / math.sqrt(1.0 + slope * slope)
        count += 1
        # From the middle of the upper face it runs straight out, and so on the lower one.
        for along in (abs(x), abs(z)):
            if e > 0.0 and e * steep < along:
                y = along / math.sqrt(along * along + e * e)
                out[count], out[count + 1] = y, -y
                count += 2
    return count
