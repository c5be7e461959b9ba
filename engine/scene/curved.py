"""Shapes made of a Bézier spline: a profile turned about an axis, a curve made into a tube."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, Field

from engine.numerics.description import Description, Finite, Point
from engine.scene.bezier import has_ends, parameters, spline
from engine.scene.part import Part, grid_triangles, joined, with_corners

Sides = Annotated[int, Field(ge=3, le=2048)]
Segments = Annotated[int, Field(ge=1, le=512)]
Profile = tuple[Annotated[float, Field(ge=0, le=1e6)], Finite]


class Revolution(Description):
    """A profile turned about the y axis: vases, bowls, rings.

    `profile` has the control points (radius, height) of a spline of cubic Bézier curves, each of
    which shares its last point with the next one and is cut into `segments`. The surface shows its
    outside to the right of the profile's way, radii growing to the right. Where two curves meet at
    an angle there is an edge. The texture's u runs round the axis, v along the profile.
    """

    shape: Literal["revolution"]
    profile: Annotated[list[Profile], Field(min_length=4, max_length=769), AfterValidator(has_ends)]
    segments: Segments = 8
    sides: Sides = 96


class Tube(Description):
    """Round a spline of cubic Bézier curves, `points` as of a revolution's profile; flat ends.

    The texture's u runs along the tube, v around it.
    """

    shape: Literal["tube"]
    points: Annotated[list[Point], Field(min_length=4, max_length=769), AfterValidator(has_ends)]
    radius: Annotated[float, Field(gt=0, le=1e6)] = 0.1
    segments: Segments = 16
    sides: Sides = 24


def revolution(shape: Revolution) -> Part:
    """Its triangles; each curve of the profile has vertices of its own."""
    points = np.array(shape.profile)
    pieces = len(points) // 3
    phi = 2 * np.pi * (np.arange(shape.sides + 1) % shape.sides) / shape.sides  # closes exactly
    t = parameters(4, shape.segments)
    parts = []
    for k in range(pieces):
        curve = points[3 * k : 3 * k + 4]
        u, v = np.meshgrid(np.arange(shape.sides + 1) / shape.sides, (k + t) / pieces)
        positions = _turned(spline(curve, t), phi)
        normals = _turned(spline(curve, t, 1)[:, ::-1] * [1, -1], phi)
        parts.append(
            Part(
                positions,
                with_corners(positions, grid_triangles(shape.segments, shape.sides)),
                normals / np.linalg.norm(normals, axis=1, keepdims=True),
                np.stack([u.ravel(), v.ravel()], axis=1),
            )
        )
    return joined(parts)


def _turned(flat: NDArray[np.float64], phi: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n m, 3): points (radius, height) (n, 2), each at all angles (m,) from +z towards +x."""
    r, y = flat[:, :1], flat[:, 1:]
    turned = np.stack(np.broadcast_arrays(r * np.sin(phi), y, r * np.cos(phi)), axis=-1)
    return turned.reshape(-1, 3)


def tube(shape: Tube) -> Part:
    """Its triangles and those of its two ends."""
    points = np.array(shape.points)
    t = parameters(len(points), shape.segments)
    centre, along = spline(points, t), spline(points, t, 1)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # Carry a direction along the curve without turning it about the curve.
    side = np.zeros_like(along)
    side[0] = np.cross(along[0], np.eye(3)[np.argmin(np.abs(along[0]))])
    for k in range(1, len(t)):
        side[k] = side[k - 1] - along[k] * (side[k - 1] @ along[k])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    turn = np.cross(side, along)
    about = 2 * np.pi * (np.arange(shape.sides + 1) % shape.sides) / shape.sides
    c, s = np.cos(about), np.sin(about)
    normals = c[:, None, None] * side + s[:, None, None] * turn
    rings = centre + shape.radius * normals
    u, v = np.meshgrid(t / t[-1], np.arange(shape.sides + 1) / shape.sides)
    parts = [
        Part(
            rings.reshape(-1, 3),
            grid_triangles(shape.sides, len(t) - 1),
            normals.reshape(-1, 3),
            np.stack([u.ravel(), v.ravel()], axis=1),
        )
    ]
    first = np.arange(1, shape.sides + 1)
    fan = np.stack([0 * first, first, first + 1], axis=1)
    # The ring goes counter-clockwise seen against the curve, as one looks at its start.
    for end, sign in ((0, -1), (-1, 1)):
        corners = np.concatenate([centre[[end]], rings[:, end]])
        disk = np.concatenate([[[0.0, 0.0]], np.stack([c, -sign * s], axis=1)])
        normal = np.tile(sign * along[end], (len(corners), 1))
        parts.append(Part(corners, fan[:, ::-sign], normal, 0.5 + disk / 2))
    return joined(parts)
