"""A living room at night, lit mostly by bounce.

A floor lamp shines up at the ceiling from behind an armchair, and a strip of light comes through
the half-open door of the next room: hardly anything in view is lit directly. Red rug and blue wall
tint what lies near them, and the floorboards, the pot, the vase and the lamp have gloss.
Metres; the floor at y = 0, the room from x = -2.5 to 2.5, z = -2 to 2.4, 2.6 m high.
"""

from __future__ import annotations

import math
from typing import Any

from engine.scene.builtin.pieces import Vector, bowl, box, frustum, gloss, matt, thing, walls

SUMMARY = "an interior lit mostly by bounce: a lamp behind a chair, a door ajar, some gloss"

LEFT, RIGHT, BACK, FRONT, HEIGHT = -2.5, 2.5, -2.0, 2.4, 2.6
DOOR_LEFT, DOOR_RIGHT, DOOR_HEIGHT = 0.95, 1.75, 2.05  # in the back wall
HALL = -3.4  # back wall of the next room


def document() -> dict[str, Any]:
    """The scene description."""
    return {
        "name": "room",
        "camera": {
            "position": (0.25, 1.45, 2.3),
            "target": (-0.1, 0.92, -1.4),
            "fov_y_degrees": 58,
            "width": 640,
            "height": 480,
        },
        "lights": [
            {
                "id": "lamp",
                "type": "spot",
                "position": (-1.95, 1.52, -1.5),
                "target": (-1.85, 2.6, -1.35),
                "cone_degrees": 50,
                "penumbra_degrees": 20,
                "intensity": (19, 13.8, 8.4),
            },
            {
                "id": "hall",
                "type": "area",
                "position": (1.3, 2.4, -2.75),
                "target": (1.3, 0.0, -2.75),
                "up": (0, 0, 1),
                "width": 0.9,
                "height": 0.5,
                "intensity": (9, 11, 14),
            },
            {
                "id": "key",
                "type": "spot",
                "position": (0.9, 2.45, 0.9),
                "target": (-0.2, 0.3, -0.35),
                "cone_degrees": 17,
                "penumbra_degrees": 8,
                "intensity": (9, 8.5, 7.7),
            },
        ],
        "materials": _materials(),
        "objects": [*_shell(), *_seats(), *_table(), *_shelf(), *_lamp(), *_small_things()],
    }


def _materials() -> dict[str, Any]:
    return {
        "plaster": matt(0.78, 0.76, 0.72),
        "blue wall": matt(0.16, 0.28, 0.42),
        "ceiling": matt(0.84, 0.83, 0.8),
        "boards": gloss((0.3, 0.17, 0.09), 0.04, 0.32),
        "paint": gloss((0.75, 0.74, 0.7), 0.04, 0.4),
        "rug": matt(0.55, 0.09, 0.07),
        "sofa": matt(0.32, 0.36, 0.3),
        "cushion": matt(0.75, 0.5, 0.12),
        "walnut": gloss((0.2, 0.1, 0.05), 0.04, 0.25),
        "glaze": {
            "type": "phong",
            "diffuse": (0.1, 0.3, 0.28),
            "specular": (0.2, 0.2, 0.2),
            "exponent": 90,
        },
        "porcelain": gloss((0.8, 0.79, 0.76), 0.05, 0.15),
        "brass": {
            "type": "ggx",
            "diffuse": (0, 0, 0),
            "specular": (0.82, 0.62, 0.3),
            "roughness": 0.3,
        },
        "leaf": gloss((0.1, 0.26, 0.06), 0.04, 0.45),
        "books red": matt(0.45, 0.08, 0.06),
        "books green": matt(0.1, 0.25, 0.16),
        "books cream": matt(0.7, 0.62, 0.46),
        "canvas": matt(0.72, 0.46, 0.2),
        "dark": matt(0.05, 0.05, 0.06),
    }


def _shell() -> list[dict[str, Any]]:
    """Floor, walls, ceiling, the next room behind the door, skirting."""

    def across(z: float, x0: float, x1: float, y0: float, y1: float) -> list[Vector]:
        return [(x0, y0, z), (x1, y0, z), (x1, y1, z), (x0, y1, z)]

    def along(x: float, z0: float, z1: float) -> list[Vector]:
        return [(x, 0, z0), (x, 0, z1), (x, HEIGHT, z1), (x, HEIGHT, z0)]

    def level(y: float, z0: float, z1: float) -> list[Vector]:
        return [(LEFT, y, z1), (RIGHT, y, z1), (RIGHT, y, z0), (LEFT, y, z0)]

    hinge, width = (DOOR_LEFT, 0.02), DOOR_RIGHT - DOOR_LEFT
    swing = math.radians(62)
    door = (
        hinge[0] + math.cos(swing) * width / 2,
        hinge[1],
        BACK - math.sin(swing) * width / 2,
    )
    return [
        walls("floor", "boards", level(0, HALL, FRONT)),
        walls("ceiling", "ceiling", level(HEIGHT, HALL, FRONT)[::-1]),
        walls(
            "back wall",
            "plaster",
            across(BACK, LEFT, DOOR_LEFT, 0, HEIGHT),
            across(BACK, DOOR_RIGHT, RIGHT, 0, HEIGHT),
            across(BACK, DOOR_LEFT, DOOR_RIGHT, DOOR_HEIGHT, HEIGHT),
        ),
        walls("left wall", "blue wall", along(LEFT, FRONT, BACK)),
        walls("right wall", "plaster", along(RIGHT, BACK, FRONT)),
        walls("front wall", "plaster", across(FRONT, RIGHT, LEFT, 0, HEIGHT)),
        walls(
            "next room",
            "plaster",
            across(HALL, LEFT, RIGHT, 0, HEIGHT),
            along(LEFT, BACK, HALL),
            along(RIGHT, HALL, BACK),
            across(BACK - 0.08, DOOR_LEFT, LEFT, 0, HEIGHT),
            across(BACK - 0.08, RIGHT, DOOR_RIGHT, 0, HEIGHT),
            across(BACK - 0.08, DOOR_RIGHT, DOOR_LEFT, DOOR_HEIGHT, HEIGHT),
        ),
        box("door", "paint", (width, 2.02, 0.04), door, (0, math.degrees(swing), 0)),
        box("frame left", "paint", (0.07, 2.1, 0.14), (DOOR_LEFT - 0.035, 0, BACK - 0.04)),
        box("frame right", "paint", (0.07, 2.1, 0.14), (DOOR_RIGHT + 0.035, 0, BACK - 0.04)),
        box("frame top", "paint", (0.94, 0.07, 0.14), (1.35, DOOR_HEIGHT, BACK - 0.04)),
        box("skirting", "paint", (3.38, 0.1, 0.025), (-0.81, 0, BACK + 0.0125)),
        box("skirting left", "paint", (0.025, 0.1, 4.35), (LEFT + 0.0125, 0, 0.2)),
    ]


def _seats() -> list[dict[str, Any]]:
    """An armchair in front of the lamp, a sofa along the right wall, cushions."""
    chair, turn = (-1.45, -0.75), 28.0
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))

    def part(name: str, size: Vector, at: Vector) -> dict[str, Any]:
        x, z = chair[0] + c * at[0] + s * at[2], chair[1] - s * at[0] + c * at[2]
        return box(f"chair {name}", "sofa", size, (x, at[1], z), (0, turn, 0))

    return [
        part("seat", (0.62, 0.22, 0.66), (0, 0.2, 0.03)),
        part("back", (0.82, 0.78, 0.17), (0, 0.14, -0.36)),
        part("left arm", (0.13, 0.5, 0.72), (-0.37, 0.1, 0.02)),
        part("right arm", (0.13, 0.5, 0.72), (0.37, 0.1, 0.02)),
        box("chair cushion", "cushion", (0.42, 0.42, 0.13), (-1.55, 0.42, -0.92), (-14, turn, 0)),
        box("sofa seat", "sofa", (0.78, 0.22, 1.7), (2.02, 0.2, 0.1)),
        box("sofa back", "sofa", (0.2, 0.78, 1.98), (2.36, 0.12, 0.1)),
        box("sofa far arm", "sofa", (0.88, 0.52, 0.16), (2.0, 0.1, -0.82)),
        box("sofa near arm", "sofa", (0.88, 0.52, 0.16), (2.0, 0.1, 1.02)),
        box("sofa cushion", "cushion", (0.13, 0.4, 0.4), (2.14, 0.42, -0.5), (0, -12, 16)),
    ]


def _table() -> list[dict[str, Any]]:
    """A round table on the rug."""
    x, z = 0.3, -0.25
    legs = [
        frustum(f"table leg {k}", "walnut", 0.018, 0.026, 0.4, (x + dx, 0.012, z + dz))
        for k, (dx, dz) in enumerate([(0.28, 0.22), (-0.28, 0.22), (0.28, -0.22), (-0.28, -0.22)])
    ]
    return [
        box("rug", "rug", (2.3, 0.012, 1.7), (0.15, 0, -0.25)),
        frustum("table top", "walnut", 0.48, 0.48, 0.03, (x, 0.412, z)),
        *legs,
    ]


def _shelf() -> list[dict[str, Any]]:
    """A low shelf with books against the back wall, a picture above."""
    x, z, depth = -0.35, BACK + 0.19, 0.3
    boards = [
        box(f"shelf board {k}", "walnut", (1.5, 0.03, depth), (x, y, z))
        for k, y in enumerate((0.06, 0.4, 0.74))
    ]
    sides = [
        box(f"shelf side {k}", "walnut", (0.03, 0.77, depth), (x + side * 0.765, 0, z))
        for k, side in enumerate((-1, 0, 1))
    ]
    books = []
    place, colours = x - 0.72, ("books red", "books green", "books cream")
    for k in range(26):
        width, height = 0.034 + 0.012 * ((k * 7) % 4), 0.2 + 0.02 * ((k * 5) % 5)
        if place < x - 0.02 < place + width + 0.02:
            place = x + 0.025
        if place + width > x + 0.72:
            break
        at = (place + width / 2, 0.43, z - 0.02)
        books.append(box(f"book {k}", colours[(k * 4 + k // 3) % 3], (width, height, 0.21), at))
        place += width + 0.002 + (0.12 if k % 8 == 7 else 0)
    return [
        *boards,
        *sides,
        *books,
        box("shelf back", "walnut", (1.5, 0.74, 0.02), (x, 0.03, BACK + 0.03)),
        box("picture frame", "dark", (0.86, 0.66, 0.03), (x, 1.25, BACK + 0.02)),
        box("picture", "canvas", (0.78, 0.58, 0.01), (x, 1.29, BACK + 0.04)),
    ]


def _lamp() -> list[dict[str, Any]]:
    """The uplight: an open brass bowl on a pole, behind the chair."""
    x, z = -1.95, -1.5
    bowl_mesh = {"shape": "polygons", "polygons": bowl(x, 1.4, z, 0.06, 0.19, 0.14)}
    return [
        frustum("lamp foot", "brass", 0.15, 0.13, 0.025, (x, 0, z)),
        frustum("lamp pole", "brass", 0.013, 0.013, 1.375, (x, 0.025, z)),
        {"name": "lamp bowl", "material": "brass", "mesh": bowl_mesh},
    ]


def _small_things() -> list[dict[str, Any]]:
    """A pot and a vase, fruit, a plant in the corner."""
    leaves = []
    for k in range(14):
        angle, lean = 2.4 * k, 20 + 9 * (k % 5)
        reach = 0.17 + 0.03 * (k % 3)
        at = (
            2.05 + reach * math.cos(angle),
            0.62 + 0.075 * (k % 6),
            -1.6 - reach * math.sin(angle),
        )
        leaves.append(
            {
                "name": f"leaf {k}",
                "material": "leaf",
                "mesh": {"shape": "sphere", "radius": 1, "rings": 8},
                "transform": {
                    "translate": at,
                    "rotate_degrees": (0, math.degrees(angle), lean),
                    "scale": (0.2, 0.012, 0.07),
                },
            }
        )
    return [
        frustum("plant pot", "glaze", 0.15, 0.2, 0.34, (2.05, 0, -1.6)),
        frustum("plant stem", "leaf", 0.02, 0.01, 0.7, (2.05, 0.3, -1.6)),
        *leaves,
        thing(
            "pot", "glaze", {"shape": "sphere", "radius": 0.11, "rings": 32}, (0.42, 0.545, -0.4)
        ),
        frustum("pot neck", "glaze", 0.045, 0.06, 0.06, (0.42, 0.63, -0.4)),
        thing("orange", "cushion", {"shape": "sphere", "radius": 0.042}, (0.13, 0.484, -0.14)),
        thing("apple", "books red", {"shape": "sphere", "radius": 0.04}, (0.21, 0.482, -0.09)),
        frustum("saucer", "porcelain", 0.1, 0.13, 0.015, (0.17, 0.442, -0.12)),
        frustum("vase", "porcelain", 0.07, 0.045, 0.28, (-0.8, 0.77, BACK + 0.2)),
        thing("globe", "brass", {"shape": "sphere", "radius": 0.09}, (0.15, 0.86, BACK + 0.2)),
    ]
