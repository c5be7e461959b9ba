"""A teapot on a shiny tray in a studio: a scene in which to edit materials.

After figure 4 of Ben-Artzi, Egan, Ramamoorthi, Durand 2008, with its three materials: what tells
the tray's is the teapot that it mirrors, and the teapot shows its own spout and handle. Metres;
the tray lies at y = 0.
"""

from __future__ import annotations

from typing import Any

from engine.scene.builtin.pieces import rounded, thing

SUMMARY = "Newell's teapot on a shiny tray in a studio, with three materials to edit"

SCALE = 0.05  # metres in a unit of Newell's
FLOOR = 0.006  # of the tray, above its underside


def document() -> dict[str, Any]:
    """The scene description."""
    return {
        "name": "teatray",
        "camera": {
            "position": (0.13, 0.35, 0.57),
            "target": (0.01, 0.052, 0.0),
            "fov_y_degrees": 31,
            "width": 320,
            "height": 240,
        },
        "environment": {"map": "studio", "rotation_degrees": 120, "intensity": 1.25},
        "lights": [],
        "materials": {
            "teapot": {
                "type": "cook_torrance",
                "diffuse": (0.06, 0.25, 0.28),
                "specular": (0.06, 0.06, 0.06),
                "roughness": 0.15,
            },
            "handles": {
                "type": "blinn_phong",
                "diffuse": (0.2, 0.075, 0.03),
                "specular": (0.1, 0.1, 0.1),
                "exponent": 60,
            },
            "tray": {
                "type": "blinn_phong",
                "diffuse": (0.06, 0.06, 0.06),
                "specular": (0.62, 0.59, 0.55),
                "exponent": 1000,
            },
        },
        "objects": [
            _pot("teapot", "teapot", ["bottom", "body", "rim", "lid", "spout"]),
            _pot("handles", "handles", ["knob", "handle"]),
            thing("tray", "tray", _tray(), (0, 0, 0)),
        ],
    }


def _pot(name: str, material: str, parts: list[str]) -> dict[str, Any]:
    """Parts of the teapot, which stands on the tray."""
    return {
        "name": name,
        "material": material,
        "mesh": {"shape": "teapot", "segments": 16, "parts": parts},
        "transform": {"translate": (0, FLOOR, 0), "scale": SCALE},
    }


def _tray() -> dict[str, Any]:
    """Round, with a low rim."""
    profile = rounded(
        (0, 0, 0),
        (0.24, 0, 0.01),
        (0.275, 0.026, 0.002),
        (0.27, 0.03, 0.002),
        (0.238, FLOOR, 0.012),
        (0, FLOOR, 0),
    )
    return {"shape": "revolution", "profile": profile, "sides": 128}
