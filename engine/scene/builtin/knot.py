"""A brushed knot over a matt floor, under an environment: what `glossy_prt` is about.

The material of the knot is the paper's Ashikhmin-Shirley (Wang, Tran, Luebke 2006, §5), its grain
along the tube. Shadows fall on the floor, and the floor's colour on the knot. Metres; the floor at
y = 0.
"""

from __future__ import annotations

from typing import Any

from engine.scene.builtin.pieces import matt, thing

SUMMARY = "a glossy torus knot, brushed along its tube, over a matt floor in a studio"

FLOOR_SIZE = 6.0
FLOOR_CUTS = 96  # shadows lie between vertices


def document() -> dict[str, Any]:
    """The scene description."""
    knot = {
        "shape": "torus_knot",
        "turns": (2, 3),
        "radius": 0.5,
        "ring": 0.21,
        "tube": 0.11,
        "segments": 512,
        "sides": 40,
    }
    return {
        "name": "knot",
        "camera": {
            "position": (0.9, 1.9, 3.1),
            "target": (0.0, 0.68, 0.0),
            "fov_y_degrees": 34,
            "width": 512,
            "height": 512,
        },
        "environment": {"map": "studio"},
        "lights": [
            {
                "id": "key",
                "type": "spot",
                "position": (-1.6, 2.6, 1.4),
                "target": (0.0, 0.5, 0.0),
                "cone_degrees": 24,
                "penumbra_degrees": 10,
                "intensity": (5, 4.6, 4.1),
            },
            {
                "id": "rim",
                "type": "point",
                "position": (1.3, 1.9, -1.8),
                "intensity": (0.8, 1.0, 1.4),
            },
        ],
        "materials": {
            "brushed": {
                "type": "ashikhmin_shirley",
                "diffuse": (0.5, 0.5, 0.5),
                "specular": (0.75, 0.75, 0.75),
                "exponent_u": 10,
                "exponent_v": 100,
            },
            "floor": matt(0.45, 0.16, 0.11),
        },
        "objects": [
            # Upright, leaning back a little, and just off the floor.
            thing("knot", "brushed", knot, (0.0, 0.84, 0.0), (72, 0, 0)),
            thing(
                "floor",
                "floor",
                {
                    "shape": "rectangle",
                    "size": (FLOOR_SIZE, FLOOR_SIZE),
                    "segments": (FLOOR_CUTS, FLOOR_CUTS),
                },
                (0.0, 0.0, 0.0),
                (-90, 0, 0),
            ),
        ],
    }
