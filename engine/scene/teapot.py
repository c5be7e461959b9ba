"""Newell's teapot: bicubic Bézier patches, tessellated with their exact normals.

The control points are those of Martin Newell, 1975, as printed in Crow 1987, *The Origins of the
Teapot* (IEEE Computer Graphics and Applications 7:1), with the bottom that others added. What
is round is given for a quarter and turned; handle and spout are given for a half and mirrored.

The data are open where the pot is: between lid and rim, and at the tip of the spout. Handle and
spout end within the body, but for a sliver at the handle's lower end.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from engine.numerics.description import Description
from engine.scene.bezier import parameters, surface
from engine.scene.part import Part, grid_triangles, joined, with_corners

PartName = Literal["bottom", "body", "rim", "lid", "knob", "handle", "spout"]


class Teapot(Description):
    """Newell's teapot in his own units: on y = 0, 3.15 high, its spout at +x, its handle at -x.

    Every patch is cut into `segments` both ways. Only the `parts` named are there. The texture's u
    runs round the pot, the handle or the spout, v up the pot and along handle and spout.
    """

    shape: Literal["teapot"]
    segments: Annotated[int, Field(ge=2, le=128)] = 16
    parts: Annotated[tuple[PartName, ...], Field(min_length=1)] = (
        "bottom",
        "body",
        "rim",
        "lid",
        "knob",
        "handle",
        "spout",
    )


# From the middle of the bottom up to the inside of the rim, and from the lid's rim up to the top of
# the knob. A row (r, a, y) stands for (r, 0), (r, a), (a, r), (0, r) at height y.
_POT = (
    (0, 0, 0),
    (1.425, 0.798, 0),
    (1.5, 0.84, 0.075),
    (1.5, 0.84, 0.15),
    (1.5, 0.84, 0.225),
    (2, 1.12, 0.45),
    (2, 1.12, 0.9),
    (2, 1.12, 1.35),
    (1.75, 0.98, 1.875),
    (1.5, 0.84, 2.4),
    (1.4375, 0.805, 2.53125),
    (1.3375, 0.749, 2.53125),
    (1.4, 0.784, 2.4),
)
_LID = (
    (1.3, 0.728, 2.4),
    (1.3, 0.728, 2.55),
    (0.4, 0.224, 2.55),
    (0.2, 0.112, 2.7),
    (0, 0, 2.85),
    (0.8, 0.45, 3.15),
    (0, 0, 3.15),
)
# From the top of the handle down to its lower end, and from the body to the tip of the spout. A row
# (x, y, X, Y, w) stands for (x, y, 0), (x, y, w), (X, Y, w), (X, Y, 0).
_HANDLE = (
    (-1.6, 2.025, -1.5, 2.25, 0.3),
    (-2.3, 2.025, -2.5, 2.25, 0.3),
    (-2.7, 2.025, -3, 2.25, 0.3),
    (-2.7, 1.8, -3, 1.8, 0.3),
    (-2.7, 1.575, -3, 1.35, 0.3),
    (-2.5, 1.125, -2.65, 0.9375, 0.3),
    (-2, 0.9, -1.9, 0.6, 0.3),
)
_SPOUT = (
    (1.7, 1.425, 1.7, 0.6, 0.66),
    (2.6, 1.425, 3.1, 0.825, 0.66),
    (2.3, 2.1, 2.4, 2.025, 0.25),
    (2.7, 2.4, 3.3, 2.4, 0.25),
    (2.8, 2.475, 3.525, 2.49375, 0.25),
    (2.9, 2.475, 3.45, 2.5125, 0.15),
    (2.8, 2.4, 3.2, 2.4, 0.15),
)
# The rows of every part, from the first to before the last.
_PARTS: dict[str, tuple[tuple[tuple[float, ...], ...], int, int]] = {
    "bottom": (_POT, 0, 4),
    "body": (_POT, 3, 10),
    "rim": (_POT, 9, 13),
    "lid": (_LID, 0, 4),
    "knob": (_LID, 3, 7),
    "handle": (_HANDLE, 0, 7),
    "spout": (_SPOUT, 0, 7),
}


def teapot(shape: Teapot) -> Part:
    """The triangles of the parts."""
    return joined([_tessellated(name, shape.segments) for name in _PARTS if name in shape.parts])


def control_points(part: str) -> NDArray[np.float64]:
    """(3K + 1, 3L + 1, 3): K patches along v by L along u, neighbours with points in common.

    Seen from outside, u runs to the right where v runs up.
    """
    rows, first, last = _PARTS[part]
    laid_out = _round if len(rows[0]) == 3 else _mirrored
    return np.array([laid_out(*row) for row in rows[first:last]])


def _round(r: float, a: float, y: float) -> list[tuple[float, float, float]]:
    """A quarter and its three turns, from +x by way of -z."""
    quarter, row = [(r, 0.0), (r, a), (a, r)], []
    for _ in range(4):
        row += quarter
        quarter = [(-s, x) for x, s in quarter]
    return [(x, y, -s) for x, s in [*row, (r, 0.0)]]


def _mirrored(
    x: float, y: float, far_x: float, far_y: float, w: float
) -> list[tuple[float, float, float]]:
    """A half and its mirror image, by way of +z."""
    half = [(x, y, 0.0), (x, y, w), (far_x, far_y, w), (far_x, far_y, 0.0)]
    return [*half, *((x, y, -z) for x, y, z in half[2::-1])]


def _tessellated(name: str, segments: int) -> Part:
    """All patches of a part as one grid."""
    points = control_points(name)
    v, u = (parameters(count, segments) for count in points.shape[:2])
    positions, along_u = surface(points, v, u), surface(points, v, u, u_order=1)
    # At a pole ∂x/∂u is 0, and ∂²x/∂u∂v is what it comes from or goes to.
    for row, sign in ((0, 1), (-1, -1)):
        if (points[row] == points[row, 0]).all():
            positions[row] = points[row, 0]
            along_u[row] = sign * surface(points, v[[row]], u, v_order=1, u_order=1)[0]
    normals = np.cross(along_u, surface(points, v, u, v_order=1)).reshape(-1, 3)
    # The texture goes on through the parts of the pot, and through those of the lid.
    rows, first, _ = _PARTS[name]
    up = (first / 3 + v) / (len(rows) // 3)
    corners = positions.reshape(-1, 3)
    return Part(
        corners,
        with_corners(corners, grid_triangles(len(v) - 1, len(u) - 1)),
        normals / np.linalg.norm(normals, axis=1, keepdims=True),
        np.stack(np.meshgrid(u / u[-1], up), axis=-1).reshape(-1, 2),
    )
