"""Two regimes at once, where one might hide the other."""

from __future__ import annotations

from engine.measure.regimes.geometry import SUN
from engine.measure.regimes.lights import BETWEEN, UP, close_to_floor, under_eight_suns
from engine.measure.regimes.materials import WHITE
from engine.measure.regimes.regime import Mend, Regime
from engine.measure.regimes.stages import (
    BEHIND,
    COARSER,
    LAMP,
    POINT,
    Described,
    ball_on_floor,
    blinn,
    floor_alone,
    metal,
    of,
    phong,
    rectangle,
    room,
)
from engine.scene.edits import Edits

ON_THE_LEFT: Described = {
    **POINT, "type": "spot", "position": [0.3, 0.5, 0.3], "target": [-1, 0, 0],
    "cone_degrees": 25, "penumbra_degrees": 5,
}  # fmt: skip

OFF_THE_WALL = close_to_floor(*BETWEEN, 0.15)[0]

TOGETHER = (
    Regime(
        "tiny light and closed white room",
        "direct_to_indirect",
        "A lamp that samples miss half of, whose light bounces twenty times.",
        of(room, wall=WHITE, **UP),
        1.0,
        {"gather_samples": 4096, "bounces": 0},
        close_to_floor(*BETWEEN)[0],
        ("light_between_samples", "bounces_truncated"),
        Mend("the lamp off the wall, bounces 5", {"bounces": 5}, edit=OFF_THE_WALL),
        seen_as=close_to_floor(*BETWEEN, albedo=0.95)[1],
    ),
    Regime(
        "near mirror 1 cm before a wall",
        "direct_to_indirect",
        "The mirror is blurred, and the wall behind it is nearer than samples lie apart.",
        of(
            room,
            rectangle("mirror", "thing", [1.9, 1.9], [0, 0, -0.99]),
            thing=metal(0.05),
            lights=[ON_THE_LEFT],
        ),
        0.3,
        {"gather_samples": 1024},
        codes=("mirror_blurred", "surfaces_between_samples"),
        mend=Mend("gather_samples 16384", {"gather_samples": 16384}),
    ),
    Regime(
        "glossy and coarse",
        "glossy_prt",
        "Neither the lobe nor the shadow fits.",
        of(ball_on_floor, phong(100, 0.05), phong(100, 0.3, 0.3), cuts=3, environment=SUN),
        1.0,
        codes=("too_glossy_for_terms", "mesh_too_coarse"),
        mend=Mend(
            "terms 16, 48 cuts for 3",
            {"terms": 16},
            scene=of(ball_on_floor, phong(100, 0.05), phong(100, 0.3, 0.3), environment=SUN),
        ),
        small=COARSER,
    ),
    Regime(
        "sharp gloss in a closed room",
        "brdf_editing",
        "The lobe is narrower than elements, gloss shows gloss, and light bounces on.",
        of(room, wall=blinn(30, 0.3), lights=[BEHIND]),
        0.6,
        {"bands": 16, "gather_samples": 1024, "bounces": 1},
        Edits(materials={"wall": {"exponent": 5000}}),
        ("too_sharp_for_bands", "gloss_seen_as_matt", "bounces_truncated"),
    ),
    Regime(
        "sharp gloss under a sky",
        "wavelet_brdf",
        "The lobe is narrower than a cell, and the sky does not shine.",
        of(
            floor_alone,
            phong(3000),
            environment={"map": [1, 1, 1]},
            lights=[{**POINT, "position": LAMP["position"]}],
        ),
        0.9,
        codes=("lobe_narrower_than_cells", "environment_left_out"),
        mend=Mend("direct_to_indirect", {"gather_samples": 1024}, "direct_to_indirect"),
    ),
    Regime(
        "glossy floor under eight suns",
        "direct_to_indirect",
        "Rays are too few for the suns, and for their mirror images.",
        of(under_eight_suns, phong(200)),
        0.15,
        {"gather_samples": 4096},
        codes=("environment_too_sharp", "caustics_spread"),
    ),
)
