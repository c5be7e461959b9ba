"""Meshes that are too coarse, too simple, too thin or too bumpy."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.measure.regimes.regime import Mend, Regime
from engine.measure.regimes.stages import (
    COARSER,
    GREY,
    POINT,
    Described,
    ball_on_floor,
    built,
    camera,
    cornell,
    of,
    phong,
    room,
)
from engine.scene.build import build
from engine.scene.builtin import knot
from engine.scene.edits import Edits
from engine.scene.open import describe
from engine.scene.scene import Scene

SUN: Described = {
    "map": [0.1, 0.1, 0.1],
    "area_light": {"direction": [0.6, -1, 0.2], "radius_degrees": 10, "radiance": [20, 20, 20]},
}


def slats(side: int) -> Scene:
    """A blind in a room: forty slats of 5 mm, 3 cm apart."""
    blind = [
        {
            "name": f"slat {k}",
            "material": "thing",
            "mesh": {"shape": "box", "size": [1.2, 0.005, 0.02]},
            "transform": {"translate": [0, -0.9 + 0.03 * k, -0.5], "rotate_degrees": [35, 0, 0]},
        }
        for k in range(40)
    ]
    return room(
        side,
        *blind,
        lights=[{**POINT, "position": [0.3, 0.75, 0.3]}],
        position=[0.1, 0.2, 0.95],
        target=[0, -0.35, 0],
    )


def small_knot(side: int) -> Scene:
    """The built-in knot, matt, of fewer triangles, which shadows itself."""
    document = knot.document()
    document["camera"] |= {"width": side, "height": side}
    document["lights"], document["environment"] = [], SUN
    document["materials"]["brushed"] = GREY
    body, floor = document["objects"]
    body["mesh"] |= {"segments": 192, "sides": 16}
    floor["mesh"]["segments"] = [24, 24]
    return build(describe(document), Path())


def terrain(side: int, material: Described, cells: int = 64, steep: float = 0.1) -> Scene:
    """Bumpy ground of facets smaller than pixels, seen from afar."""
    rng = np.random.default_rng(1)
    x = np.linspace(-2, 2, cells + 1)
    z = steep * 4 / cells * rng.standard_normal((cells + 1, cells + 1))
    p = np.stack([*np.meshgrid(x, x, indexing="ij"), z], axis=-1).tolist()
    faces = [
        corners
        for i in range(cells)
        for j in range(cells)
        for a, b, c, d in [(p[i][j], p[i + 1][j], p[i + 1][j + 1], p[i][j + 1])]
        for corners in ([a, b, c], [a, c, d])
    ]
    return built(
        camera=camera(side, position=[0.1, -8, 16], target=[0, 0, 0], fov_y_degrees=10),
        lights=[
            {"id": "sun", "type": "distant", "direction": [-0.3, -0.4, -1], "intensity": [3] * 3}
        ],
        materials={"ground": material},
        objects=[
            {
                "name": "ground",
                "mesh": {"shape": "polygons", "polygons": faces},
                "material": "ground",
            }
        ],
    )


GEOMETRY = (
    Regime(
        "blind of thin slats",
        "direct_to_indirect",
        "Things thinner than samples lie apart take over the light of what is beside them.",
        slats,
        0.15,
        {"gather_samples": 256},
        codes=("surfaces_between_samples",),
    ),
    Regime(
        "shadow ends within pixels",
        "direct_to_indirect",
        "Where a spot's rim and its shadows end, a pixel is lit or it is not.",
        cornell,
        0.08,
        {"gather_samples": 16384},
        Edits(
            lights=[
                {"id": "ceiling", "enabled": False},
                {
                    **POINT,
                    "id": "key",
                    "type": "spot",
                    "cone_degrees": 20.0,
                    "penumbra_degrees": 2,
                    "position": [0.15, 0.45, 0.1],
                    "target": [0.2, 0.2, 0.56],
                },
            ]
        ),
        small={"gather_samples": 4096},
    ),
    Regime(
        "coarse mesh under a sharp shadow",
        "glossy_prt",
        "Transport is stored at vertices: shadows are as sharp as the mesh is fine.",
        of(ball_on_floor, GREY, GREY, cuts=3, environment=SUN),
        0.3,
        codes=("mesh_too_coarse",),
        mend=Mend("48 cuts for 3", scene=of(ball_on_floor, GREY, GREY, cuts=48, environment=SUN)),
        small=COARSER,
    ),
    Regime(
        "occluders of a hundred vertices",
        "glossy_prt",
        "Shadows are those of a simpler mesh.",
        small_knot,
        0.4,
        {"occluder_vertices": 100},
        codes=("occluders_too_simple",),
        mend=Mend("occluder_vertices 0", {"occluder_vertices": 0}),
        small=COARSER,
    ),
    Regime(
        "bumpy ground from afar",
        "wavelet_brdf",
        "Facets smaller than pixels show the finest level of detail, one facet for a pixel.",
        of(terrain, phong(40)),
        1.2,
        codes=("facets_within_pixels",),
        mend=Mend("detail footprint", {"detail": "footprint"}),
    ),
)
