"""Materials that send light on too often, codes that are too small, textures that are left out."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.measure.regimes.regime import Mend, Regime
from engine.measure.regimes.stages import (
    BEHIND,
    COARSER,
    GREY,
    LIT,
    Described,
    ball_alone,
    built,
    camera,
    of,
    rectangle,
    room,
    with_picture,
)
from engine.scene.builtin.pieces import matt
from engine.scene.edits import Edits
from engine.scene.scene import Scene

WHITE = matt(0.95, 0.95, 0.95)
ROUGH: Described = {
    "type": "ggx", "diffuse": [0.2] * 3, "specular": [0.5] * 3,
    "roughness": {"texture": "rough.png"},
}  # fmt: skip


def pit(side: int, albedo: float = 0.95) -> Scene:
    """A deep box without a lid under an even sky."""
    sides = {
        "floor": ([0, -1, 0], [-90, 0, 0]),
        "back": ([0, 0, -1], [0, 0, 0]),
        "front": ([0, 0, 1], [0, 180, 0]),
        "left": ([-1, 0, 0], [0, 90, 0]),
        "right": ([1, 0, 0], [0, -90, 0]),
    }
    return built(
        camera=camera(side, position=[0.1, 0.9, 0.6], target=[0, -1, -0.3], fov_y_degrees=60),
        environment={"map": [1, 1, 1], "background": False},
        materials={"wall": matt(*[albedo] * 3)},
        objects=[
            rectangle(name, "wall", [2, 2], at, turn, (10, 10))
            for name, (at, turn) in sides.items()
        ],
    )


def checked(side: int, **light: object) -> Scene:
    """A ball whose roughness is a chequered texture, from almost a mirror's to matt."""

    def make(folder: Path) -> Scene:
        return ball_alone(side, ROUGH, folder, **light)

    # As sRGB, which the numbers of an image of 8 bits are, 0.2 and 0.8.
    rough = np.where(np.indices((8, 16)).sum(axis=0) % 2, 0.6, 0.033)[..., None]
    return with_picture(make, np.repeat(rough, 3, axis=2).astype(np.float32), "rough.png")


BY_LAMP = {"lights": [LIT]}
STUDIO = {"environment": {"map": "studio", "background": False}}

MATERIALS = (
    Regime(
        "white closed room",
        "direct_to_indirect",
        "Of albedo 0.95, where light bounces twenty times.",
        of(room, wall=WHITE),
        0.95,
        {"gather_samples": 4096, "bounces": 0},
        codes=("bounces_truncated",),
        mend=Mend("bounces 5", {"bounces": 5}),
    ),
    Regime(
        "white pit",
        "glossy_prt",
        "Light bounces on after one pass.",
        pit,
        0.75,
        codes=("bounces_truncated",),
        mend=Mend("bounces 6", {"bounces": 6}),
        small=COARSER,
    ),
    Regime(
        "wall painted white",
        "brdf_editing",
        "The series ends after three bounces on the cloud.",
        of(room, wall=GREY),
        0.75,
        {"gather_samples": 4096},
        Edits(materials={"wall": {"diffuse": [0.9] * 3}}),
        ("bounces_truncated",),
        Mend("bounces 8", {"bounces": 8}),
    ),
    Regime(
        "closed room without indirect light",
        "wavelet_brdf",
        "Codes are looked up for lamps alone: nothing is reflected twice.",
        of(room, lights=[BEHIND]),
        0.7,
        codes=("indirect_left_out",),
        mend=Mend("direct_to_indirect", {"gather_samples": 4096}, "direct_to_indirect"),
    ),
    Regime(
        "code of 14 kB",
        "wavelet_brdf",
        "Too few bytes for what the material does.",
        of(ball_alone, {"type": "measured", "file": "brushed"}, **BY_LAMP),
        0.45,
        {"bytes": 14000},
        codes=("code_too_small",),
        mend=Mend("bytes 0", {"bytes": 0}),
    ),
    Regime(
        "texture of roughness from afar",
        "wavelet_brdf",
        "A material with textures is drawn by its formula, at the finest detail.",
        of(checked, **BY_LAMP),
        0.08,
        codes=("drawn_by_formula",),
    ),
    Regime(
        "texture of roughness under a sky",
        "glossy_prt",
        "Terms are of a material as a whole.",
        of(checked, **STUDIO),
        0.9,
        codes=("textures_left_out",),
        mend=Mend("direct_to_indirect", {"gather_samples": 1024}, "direct_to_indirect"),
        small=COARSER,
    ),
    Regime(
        "texture of roughness in hand",
        "brdf_editing",
        "Elements are of a material as a whole, while it is in hand.",
        of(checked, **BY_LAMP),
        0.9,
        {"gather_samples": 1024},
        Edits(materials={"ball": {"specular": [0.6] * 3}}),
        ("textures_left_out",),
    ),
)
