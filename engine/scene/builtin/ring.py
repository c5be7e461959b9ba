"""A metal ring in low sun that gathers light to a caustic: a scene in which to edit materials.

After figure 11 of Ben-Artzi, Egan, Ramamoorthi, Durand 2008, with its two materials. The sun comes
over the near wall and meets the far wall from inside, a part of a cylinder, which gathers parallel
light to a nephroid with its cusp at half the radius. How sharp that is follows from the gloss of
the ring, and from the sun, which is wider here than the real one. Metres; the plane is y = 0.
"""

from __future__ import annotations

from typing import Any

from engine.scene.builtin.pieces import rounded, thing

SUMMARY = "a metal ring in low sun that draws a caustic on the plane, with two materials to edit"

INSIDE, OUTSIDE, HEIGHT = 0.04, 0.0435, 0.018
EDGE = 0.0012  # how far its edges are rounded


def document() -> dict[str, Any]:
    """The scene description."""
    return {
        "name": "ring",
        "camera": {
            "position": (0.0, 0.165, 0.135),
            "target": (0.0, 0.0, 0.0),
            "fov_y_degrees": 29,
            "width": 400,
            "height": 400,
        },
        "environment": {"map": "studio", "intensity": 0.2},
        "lights": [
            {
                "id": "sun",
                "type": "sun",
                "direction": (0.6, -0.45, -0.8),
                "diameter_degrees": 3,
                "intensity": (3.2, 3.08, 2.85),
            },
        ],
        "materials": {
            "ring": {
                "type": "ggx",
                "diffuse": (0, 0, 0),
                "specular": (0.92, 0.72, 0.42),
                "roughness": 0.18,
            },
            "plane": {
                "type": "blinn_phong",
                "diffuse": (0.36, 0.36, 0.38),
                "specular": (0.05, 0.05, 0.05),
                "exponent": 100,
            },
        },
        "objects": [
            thing("ring", "ring", _ring(), (0, 0, 0)),
            thing(
                "plane", "plane", {"shape": "rectangle", "size": (0.6, 0.6)}, (0, 0, 0), (-90, 0, 0)
            ),
        ],
    }


def _ring() -> dict[str, Any]:
    """From the middle of its inner wall down, and round its section."""
    middle = (INSIDE, HEIGHT / 2, 0)
    profile = rounded(
        middle,
        (INSIDE, 0, EDGE),
        (OUTSIDE, 0, EDGE),
        (OUTSIDE, HEIGHT, EDGE),
        (INSIDE, HEIGHT, EDGE),
        middle,
    )
    return {"shape": "revolution", "profile": profile, "segments": 6, "sides": 360}
