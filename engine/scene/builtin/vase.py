"""Tulips in a brushed vase on a table: a scene in which to edit materials.

After figure 9 of Ben-Artzi, Egan, Ramamoorthi, Durand 2008, with its four materials: matt flowers,
stems with a gloss, a glossy table, and a vase whose highlight can be stretched along or across its
grain, which runs round it. Metres; the table's top is at y = 0.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.scene.builtin.pieces import Flat, Vector, gloss, matt, rounded, thing
from engine.scene.description import Transform

SUMMARY = "tulips in a vase of brushed metal on a polished table, with four materials to edit"

# Radius and height: the outside up to the lip, the inside down to the bottom.
PROFILE: list[Flat] = [
    (0, 0), (0.015, 0), (0.03, 0), (0.045, 0),
    (0.049, 0), (0.05, 0.002), (0.052, 0.006),
    (0.064, 0.03), (0.09, 0.07), (0.09, 0.115),
    (0.09, 0.165), (0.037, 0.185), (0.037, 0.23),
    (0.037, 0.25), (0.045, 0.268), (0.056, 0.28),
    (0.058, 0.2822), (0.0545, 0.285), (0.0525, 0.2828),
    (0.0415, 0.2708), (0.033, 0.25), (0.033, 0.23),
    (0.033, 0.185), (0.086, 0.165), (0.086, 0.115),
    (0.086, 0.05), (0.05, 0.012), (0, 0.012),
]  # fmt: skip
# Tulips: the direction in which one leans, in degrees from +x towards -z, how far, how high its cup
# begins.
TULIPS = (
    (200, 0.025, 0.455),
    (20, 0.12, 0.405),
    (60, 0.095, 0.43),
    (162, 0.115, 0.395),
    (250, 0.09, 0.36),
    (315, 0.085, 0.34),
)
PETAL = (0.008, 0.03, 0.021)  # half of its thickness, height and width
# Leaves: the direction in which one leans, by how many degrees, its length.
LEAVES = ((40, 26, 0.24), (150, 28, 0.22), (285, 24, 0.19), (350, 27, 0.2))


def document() -> dict[str, Any]:
    """The scene description."""
    vase = {"shape": "revolution", "profile": PROFILE, "segments": 12, "sides": 128}
    return {
        "name": "vase",
        "camera": {
            "position": (0.12, 0.42, 1.0),
            "target": (0.0, 0.245, 0.0),
            "fov_y_degrees": 32,
            "width": 512,
            "height": 512,
        },
        "environment": {"map": "studio", "rotation_degrees": 120, "intensity": 1.15},
        "lights": [],
        "materials": {
            "flowers": matt(0.58, 0.05, 0.06),
            "stems": gloss((0.08, 0.25, 0.05), 0.05, 0.35),
            "table": {
                "type": "blinn_phong",
                "diffuse": (0.16, 0.065, 0.03),
                "specular": (0.22, 0.22, 0.22),
                "exponent": 500,
            },
            "vase": {
                "type": "ashikhmin_shirley",
                "diffuse": (0.05, 0.07, 0.11),
                "specular": (0.55, 0.55, 0.58),
                "exponent_u": 225,
                "exponent_v": 25,
            },
        },
        "objects": [
            thing("vase", "vase", vase, (0, 0, 0)),
            thing("table", "table", _table(), (0, 0, 0)),
            *(piece for k, tulip in enumerate(TULIPS) for piece in _tulip(k, *tulip)),
            *(_leaf(k, *leaf) for k, leaf in enumerate(LEAVES)),
        ],
    }


def _table() -> dict[str, Any]:
    profile = rounded((0, -0.03, 0), (0.45, -0.03, 0.008), (0.45, 0, 0.008), (0, 0, 0))
    return {"shape": "revolution", "profile": profile, "sides": 128}


def _tulip(k: int, degrees: float, reach: float, height: float) -> list[dict[str, Any]]:
    """A stem that comes out of the vase, and a cup of six petals round its end."""
    # Distance from the middle of the vase and height.
    curve = ((-0.02, 0.05), (0.0, 0.2), (0.33 * reach, 0.31), (reach, height))
    lean = math.atan2(reach - curve[2][0], height - curve[2][1])
    foot = (reach - 0.004 * math.sin(lean), height - 0.004 * math.cos(lean), 0)
    cup = _place(turn=(0, degrees, 0)) @ _place(at=foot, turn=(0, 0, -math.degrees(lean)))
    petals = []
    for petal in range(6):
        inner = petal % 2
        about = _place(turn=(0, 60 * petal + 25 * k, 0))
        leaning = _place((0.014 - 0.004 * inner, 0.028, 0), (0, 0, 5 * inner - 8), PETAL)
        petals.append(_ball(f"tulip {k} petal {petal}", "flowers", cup @ about @ leaning))
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    points = [(c * r, y, -s * r) for r, y in curve]
    stem = {"shape": "tube", "points": points, "radius": 0.0032, "sides": 16}
    return [thing(f"tulip {k} stem", "stems", stem, (0, 0, 0)), *petals]


def _leaf(k: int, degrees: float, lean: float, length: float) -> dict[str, Any]:
    """A leaf that comes out of the vase."""
    foot = _place((0, 0.2, 0), (0, degrees, 0)) @ _place(turn=(0, 0, -lean))
    blade = _place((0, length / 2, 0), size=(0.0018, length / 2, 0.014))
    return _ball(f"leaf {k}", "stems", foot @ blade)


def _place(
    at: Vector = (0, 0, 0), turn: Vector = (0, 0, 0), size: Vector = (1, 1, 1)
) -> NDArray[np.float64]:
    """(4, 4): scaled, then turned, then moved."""
    return Transform(translate=at, rotate_degrees=turn, scale=size).matrix()


def _ball(name: str, material: str, matrix: NDArray[np.float64]) -> dict[str, Any]:
    """A ball of radius 1, made into something else by a (4, 4) matrix."""
    mesh = {"shape": "sphere", "radius": 1, "rings": 20}
    return {"name": name, "material": material, "mesh": mesh, "transform": matrix.tolist()}
