"""Shapes that a scene description can ask for by name instead of a mesh file.

Every shape is counter-clockwise seen from outside, and brings its own shading normals and texture
coordinates (origin at the lower left). Surfaces of revolution are closed where their profile is,
the teapot is open where Newell's is, all others are closed or flat.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from engine.numerics.description import Description, Point
from engine.scene.curved import Revolution, Tube, revolution, tube
from engine.scene.part import Part, grid_triangles, joined, with_corners
from engine.scene.teapot import Teapot, teapot

Size = Annotated[float, Field(gt=0, le=1e6)]
Segments = Annotated[int, Field(ge=1, le=2048)]
Polygon = Annotated[list[Point], Field(min_length=3, max_length=64)]


class Rectangle(Description):
    """In the x-y plane around the origin, facing +z; corners of the texture at its corners.

    `segments` cuts it along x and y, for methods that store light at vertices.
    """

    shape: Literal["rectangle"]
    size: tuple[Size, Size] = (1.0, 1.0)
    segments: tuple[Segments, Segments] = (1, 1)


class Box(Description):
    """Around the origin, faces across the axes, each with the whole texture."""

    shape: Literal["box"]
    size: tuple[Size, Size, Size] = (1.0, 1.0, 1.0)


class Sphere(Description):
    """Around the origin; poles at ±y; `rings` bands from pole to pole, twice as many around."""

    shape: Literal["sphere"]
    radius: Size = 0.5
    rings: Annotated[int, Field(ge=3, le=512)] = 24


class Disk(Description):
    """In the x-y plane around the origin, facing +z."""

    shape: Literal["disk"]
    radius: Size = 0.5
    sides: Annotated[int, Field(ge=3, le=1024)] = 48


class Cylinder(Description):
    """Around the y axis and the origin, closed by caps; a cone's frustum with a `top_radius`."""

    shape: Literal["cylinder"]
    radius: Size = 0.5
    top_radius: Size | None = None
    height: Size = 1.0
    sides: Annotated[int, Field(ge=3, le=1024)] = 48


class TorusKnot(Description):
    """A tube about a curve that winds round a torus about the y axis: `turns[0]` times round the
    axis, `turns[1]` times round the ring. The texture's u runs along the tube, v around it.
    """

    shape: Literal["torus_knot"]
    turns: tuple[Annotated[int, Field(ge=1, le=16)], Annotated[int, Field(ge=0, le=16)]] = (2, 3)
    radius: Size = 0.5
    ring: Size = 0.2
    tube: Size = 0.1
    segments: Annotated[int, Field(ge=8, le=8192)] = 384
    sides: Annotated[int, Field(ge=3, le=512)] = 32


class Polygons(Description):
    """Flat convex polygons given by their corners, counter-clockwise seen from the front.

    They are shaded flat, and their texture coordinates are the corners' own order: the first
    corner at (0, 0), the second at (1, 0), the third at (1, 1), the fourth at (0, 1).
    """

    shape: Literal["polygons"]
    polygons: Annotated[list[Polygon], Field(min_length=1, max_length=10_000)]

    @model_validator(mode="after")
    def _have_area(self) -> Polygons:
        for index, polygon in enumerate(self.polygons):
            if np.linalg.norm(_area_vector(np.array(polygon))) == 0:
                raise ValueError(f"polygon {index} has no area: its corners lie on one line")
        return self


AnyShape = Annotated[
    Rectangle | Box | Sphere | Disk | Cylinder | TorusKnot | Revolution | Tube | Teapot | Polygons,
    Field(discriminator="shape"),
]


def make(shape: Any) -> Part:
    """The triangles of a shape."""
    return _MAKERS[type(shape)](shape)


def _area_vector(corners: NDArray[np.float64]) -> NDArray[np.float64]:
    """Newell's sum: along the polygon's normal, as long as its area; corners (n, 3)."""
    area: NDArray[np.float64] = np.cross(corners, np.roll(corners, -1, axis=0)).sum(axis=0) / 2
    return area


def _rectangle(shape: Rectangle) -> Part:
    columns, rows = shape.segments
    v, u = np.mgrid[0 : rows + 1, 0 : columns + 1].reshape(2, -1) / np.array([[rows], [columns]])
    uv = np.stack([u, v], axis=1)
    positions = np.zeros((len(uv), 3))
    positions[:, :2] = (uv - 0.5) * shape.size
    normals = np.tile([0.0, 0, 1], (len(uv), 1))
    return Part(positions, grid_triangles(rows, columns), normals, uv)


def _box(shape: Box) -> Part:
    front = _rectangle(Rectangle(shape="rectangle"))
    assert front.uvs is not None
    # The axes (right, up, outward) of the six faces, seen from outside.
    faces = np.array(
        [
            [[0, 0, -1], [0, 1, 0], [1, 0, 0]],
            [[0, 0, 1], [0, 1, 0], [-1, 0, 0]],
            [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
            [[1, 0, 0], [0, 0, 1], [0, -1, 0]],
            [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
            [[-1, 0, 0], [0, 1, 0], [0, 0, -1]],
        ],
        float,
    )
    outward = front.positions + np.array([0, 0, 0.5])
    positions = np.concatenate([outward @ face for face in faces]) * shape.size
    triangles = np.concatenate([front.triangles + 4 * k for k in range(6)])
    return Part(positions, triangles, np.repeat(faces[:, 2], 4, axis=0), np.tile(front.uvs, (6, 1)))


def _sphere(shape: Sphere) -> Part:
    rings, around = shape.rings, 2 * shape.rings
    v, u = np.mgrid[0 : rings + 1, 0 : around + 1].reshape(2, -1) / np.array([[rings], [around]])
    theta, phi = np.pi * v, 2 * np.pi * (u % 1)  # the seam closes exactly
    ring = np.where(v == 1, 0, np.sin(theta))  # sin π is not 0 in floating point
    normals = np.stack([ring * np.sin(phi), -np.cos(theta), ring * np.cos(phi)], axis=1)
    positions = shape.radius * normals
    triangles = with_corners(positions, grid_triangles(rings, around))
    return Part(positions, triangles, normals, np.stack([u, v], 1))


def _fan(radius: float, sides: int) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """A regular polygon around the origin in the x-y plane, (n + 1, 2), and its triangles."""
    angle = 2 * np.pi * np.arange(sides) / sides
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1) * radius
    k = np.arange(sides)
    triangles = np.stack([np.zeros(sides, np.int64), 1 + k, 1 + (k + 1) % sides], axis=1)
    return np.concatenate([[[0.0, 0.0]], rim]), triangles


def _disk(shape: Disk) -> Part:
    flat, triangles = _fan(shape.radius, shape.sides)
    positions = np.zeros((len(flat), 3))
    positions[:, :2] = flat
    return Part(
        positions,
        triangles,
        np.tile([0.0, 0, 1], (len(flat), 1)),
        0.5 + flat / (2 * shape.radius),
    )


def _cylinder(shape: Cylinder) -> Part:
    low, high = shape.radius, shape.radius if shape.top_radius is None else shape.top_radius
    v, u = np.mgrid[0:2, 0 : shape.sides + 1].reshape(2, -1) / np.array([[1], [shape.sides]])
    phi, radius = 2 * np.pi * (u % 1), low + (high - low) * v
    side = np.stack([radius * np.sin(phi), shape.height * (v - 0.5), radius * np.cos(phi)], axis=1)
    lean = np.full(len(u), (low - high) / shape.height)
    normals = np.stack([np.sin(phi), lean, np.cos(phi)], axis=1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    parts = [Part(side, grid_triangles(1, shape.sides), normals, np.stack([u, v], 1))]
    for r, sign in ((low, -1.0), (high, 1.0)):
        flat, triangles = _fan(r, shape.sides)
        cap = np.stack(
            [flat[:, 0], np.full(len(flat), sign * shape.height / 2), -sign * flat[:, 1]], axis=1
        )
        normal = np.tile([0.0, sign, 0], (len(flat), 1))
        parts.append(Part(cap, triangles, normal, 0.5 + flat / (2 * r)))
    return joined(parts)


def _torus_knot(shape: TorusKnot) -> Part:
    v, u = np.mgrid[0 : shape.sides + 1, 0 : shape.segments + 1].reshape(2, -1) / np.array(
        [[shape.sides], [shape.segments]]
    )
    about, (p, q) = 2 * np.pi * (v % 1), shape.turns  # the seams close exactly
    phi, theta = p * 2 * np.pi * (u % 1), q * 2 * np.pi * (u % 1)
    zero = np.zeros_like(u)
    away = np.stack([np.sin(phi), zero, np.cos(phi)], axis=1)
    outward = np.cos(theta)[:, None] * away + np.stack([zero, np.sin(theta), zero], axis=1)
    centre = shape.radius * away + shape.ring * outward
    # Along the curve: round the axis as far as its distance from it, and round the ring.
    turn = np.stack([np.cos(phi), zero, -np.sin(phi)], axis=1)
    rise = np.stack([zero, np.cos(theta), zero], axis=1) - np.sin(theta)[:, None] * away
    along = p * (shape.radius + shape.ring * np.cos(theta))[:, None] * turn + q * shape.ring * rise
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    # The torus's own normal is perpendicular to every curve on it.
    side = np.cross(outward, along)
    normals = np.cos(about)[:, None] * outward + np.sin(about)[:, None] * side
    return Part(
        centre + shape.tube * normals,
        grid_triangles(shape.sides, shape.segments),
        normals,
        np.stack([u, v], axis=1),
    )


def _polygons(shape: Polygons) -> Part:
    parts = []
    for polygon in shape.polygons:
        corners = np.array(polygon, float)
        normal = _area_vector(corners)
        k = np.arange(1, len(corners) - 1)
        uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], float)
        uvs = uv if len(corners) == 4 else np.resize(uv, (len(corners), 2))
        parts.append(
            Part(
                corners,
                np.stack([np.zeros_like(k), k, k + 1], axis=1),
                np.tile(normal / np.linalg.norm(normal), (len(corners), 1)),
                uvs,
            )
        )
    return joined(parts)


_MAKERS: dict[type, Callable[[Any], Part]] = {
    Rectangle: _rectangle,
    Box: _box,
    Sphere: _sphere,
    Disk: _disk,
    Cylinder: _cylinder,
    TorusKnot: _torus_knot,
    Revolution: revolution,
    Tube: tube,
    Teapot: teapot,
    Polygons: _polygons,
}
