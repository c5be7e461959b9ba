"""The Cornell box: Cornell University Program of Computer Graphics, *Cornell Box Data*.

Geometry and camera are the published measurements, millimetres here made metres; the box is not
quite square, and its coordinates put the red wall at large x, to the left of a camera that looks
along +z. The reflectances are the published spectra (400-700 nm) seen under CIE D65 by the CIE 1931
observer, in linear sRGB. The lights are ours: the published lamp is an area of the ceiling, kept
here a little below it, in a milder orange than the measured spectrum; `key` is a spot to drag.
"""

from __future__ import annotations

import math
from typing import Any

SUMMARY = "the Cornell box as published: red and green walls, two white blocks, a ceiling lamp"

WHITE = (0.738, 0.736, 0.739)
RED = (0.493, 0.049, 0.051)
GREEN = (0.069, 0.399, 0.087)

Corner = tuple[float, float, float]
Polygon = list[Corner]

FLOOR: Polygon = [(552.8, 0, 0), (0, 0, 0), (0, 0, 559.2), (549.6, 0, 559.2)]
CEILING: Polygon = [(556, 548.8, 0), (556, 548.8, 559.2), (0, 548.8, 559.2), (0, 548.8, 0)]
BACK: Polygon = [(549.6, 0, 559.2), (0, 0, 559.2), (0, 548.8, 559.2), (556, 548.8, 559.2)]
RIGHT: Polygon = [(0, 0, 559.2), (0, 0, 0), (0, 548.8, 0), (0, 548.8, 559.2)]
LEFT: Polygon = [(552.8, 0, 0), (549.6, 0, 559.2), (556, 548.8, 559.2), (556, 548.8, 0)]
APART = "back wall", "short block", "tall block"
# The tops of the blocks, which stand on the floor.
SHORT: Polygon = [(130, 165, 65), (82, 165, 225), (240, 165, 272), (290, 165, 114)]
TALL: Polygon = [(423, 330, 247), (265, 330, 296), (314, 330, 456), (472, 330, 406)]
# Half a millimetre below the ceiling, so that no rounding puts it on the wrong side.
LAMP_CENTRE, LAMP_SIZE = (278.0, 548.3, 279.5), (130.0, 105.0)


def document() -> dict[str, Any]:
    """The scene description."""
    return {
        "name": "cornell-box",
        "camera": {
            "position": _metres((278, 273, -800)),
            "target": _metres((278, 273, 0)),
            # A 35 mm lens over 25 mm of film.
            "fov_y_degrees": math.degrees(2 * math.atan(0.025 / 2 / 0.035)),
            "width": 512,
            "height": 512,
        },
        "lights": [
            {
                "id": "ceiling",
                "type": "area",
                "position": _metres(LAMP_CENTRE),
                "target": _metres((LAMP_CENTRE[0], 0, LAMP_CENTRE[2])),
                "up": (0, 0, 1),
                "width": LAMP_SIZE[0] / 1000,
                "height": LAMP_SIZE[1] / 1000,
                "intensity": (28, 21.5, 14),
            },
            {
                "id": "key",
                "type": "spot",
                "position": _metres((450, 500, 60)),
                "target": _metres((370, 0, 150)),
                "cone_degrees": 18,
                "penumbra_degrees": 8,
                "intensity": (0.3, 0.3, 0.32),
            },
        ],
        "materials": {
            "white": {"type": "diffuse", "diffuse": WHITE},
            "red": {"type": "diffuse", "diffuse": RED},
            "green": {"type": "diffuse", "diffuse": GREEN},
            # White as well, and each to be edited by itself.
            **{name: {"type": "diffuse", "diffuse": WHITE} for name in APART},
        },
        "objects": [
            _object("floor", "white", [FLOOR]),
            _object("ceiling", "white", [CEILING]),
            _object("back wall", "back wall", [BACK]),
            _object("right wall", "green", [RIGHT]),
            _object("left wall", "red", [LEFT]),
            _object("short block", "short block", _block(SHORT)),
            _object("tall block", "tall block", _block(TALL)),
        ],
    }


def _metres(point: Corner) -> Corner:
    return (point[0] / 1000, point[1] / 1000, point[2] / 1000)


def _block(top: Polygon) -> list[Polygon]:
    """The top and the four sides of a block on the floor."""
    sides: list[Polygon] = []
    for (ax, ay, az), (bx, by, bz) in zip(top, top[1:] + top[:1], strict=True):
        sides.append([(bx, by, bz), (ax, ay, az), (ax, 0.0, az), (bx, 0.0, bz)])
    return [top, *sides]


def _object(name: str, material: str, polygons: list[Polygon]) -> dict[str, Any]:
    mesh = {"shape": "polygons", "polygons": [[_metres(c) for c in p] for p in polygons]}
    return {"name": name, "material": material, "mesh": mesh}
