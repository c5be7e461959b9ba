"""Words for furnishing a scene: each makes a piece of a scene description."""

from __future__ import annotations

import math
from typing import Any

Vector = tuple[float, float, float]
Flat = tuple[float, float]

ARC = 0.5523  # of the way to the corner, for a quarter of a circle


def matt(*colour: float) -> dict[str, Any]:
    """A diffuse material."""
    return {"type": "diffuse", "diffuse": colour}


def gloss(colour: Vector, specular: float, roughness: float) -> dict[str, Any]:
    """Plastic, varnish, leaves: a diffuse base under a clear coat."""
    return {
        "type": "ggx",
        "diffuse": colour,
        "specular": (specular,) * 3,
        "roughness": roughness,
    }


def thing(
    name: str, material: str, mesh: dict[str, Any], at: Vector, turn: Vector = (0, 0, 0)
) -> dict[str, Any]:
    """An object in its place, turned by degrees."""
    transform = {"translate": at, "rotate_degrees": turn}
    return {"name": name, "material": material, "mesh": mesh, "transform": transform}


def box(
    name: str, material: str, size: Vector, at: Vector, turn: Vector = (0, 0, 0)
) -> dict[str, Any]:
    """A box that stands on the height of `at`."""
    middle = (at[0], at[1] + size[1] / 2, at[2])
    return thing(name, material, {"shape": "box", "size": size}, middle, turn)


def frustum(
    name: str, material: str, radius: float, top: float, height: float, at: Vector
) -> dict[str, Any]:
    """A cylinder or frustum that stands on the height of `at`."""
    mesh = {"shape": "cylinder", "radius": radius, "top_radius": top, "height": height}
    return thing(name, material, mesh, (at[0], at[1] + height / 2, at[2]))


def walls(name: str, material: str, *polygons: list[Vector]) -> dict[str, Any]:
    """An object of flat polygons."""
    mesh = {"shape": "polygons", "polygons": polygons}
    return {"name": name, "material": material, "mesh": mesh}


def bowl(
    x: float, y: float, z: float, low: float, high: float, height: float, sides: int = 32
) -> list[list[Vector]]:
    """The bottom and the side of an open frustum, seen from outside."""

    def rim(radius: float, at: float, k: int) -> Vector:
        angle = 2 * math.pi * k / sides
        return (x + radius * math.sin(angle), at, z + radius * math.cos(angle))

    side = [
        [rim(low, y, k), rim(low, y, k + 1), rim(high, y + height, k + 1), rim(high, y + height, k)]
        for k in range(sides)
    ]
    return [*side, [rim(low, y, -k) for k in range(sides)]]


def rounded(*corners: Vector) -> list[Flat]:
    """The profile of a surface of revolution: straight from corner to corner (radius, height, cut),
    each of them rounded from `cut` before it to `cut` behind it.
    """
    path: list[Flat] = [corners[0][:2]]
    for before, corner, after in zip(corners, corners[1:], corners[2:], strict=False):
        here, cut = corner[:2], corner[2]
        start, end = (
            _between(here, way[:2], cut / math.dist(here, way[:2])) for way in (before, after)
        )
        path += _straight(path[-1], start)
        if cut > 0:
            path += [_between(start, here, ARC), _between(end, here, ARC), end]
    return path + _straight(path[-1], corners[-1][:2])


def _between(a: Flat, b: Flat, part: float) -> Flat:
    return (a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1]))


def _straight(a: Flat, b: Flat) -> list[Flat]:
    """The control points that follow a on the way to b."""
    return [_between(a, b, 1 / 3), _between(a, b, 2 / 3), b]
