"""Lobes that are sharper than samples, terms, elements, rays or cells."""

from __future__ import annotations

from engine.measure.regimes.regime import Mend, Regime
from engine.measure.regimes.stages import (
    COARSER,
    GREY,
    LAMP,
    POINT,
    Described,
    ball_alone,
    blinn,
    floor_alone,
    hall,
    metal,
    of,
    phong,
)
from engine.scene.builtin.pieces import matt
from engine.scene.edits import Edits

# On the wall alone, so that the floor shows nothing but its mirror image.
ON_THE_WALL: Described = {
    **POINT, "type": "spot", "position": [0, 0.2, 0.6], "target": [0, -0.3, -1],
    "cone_degrees": 6, "penumbra_degrees": 1, "intensity": [8, 8, 8],
}  # fmt: skip
ON_THE_FLOOR: Described = {
    **POINT, "type": "spot", "position": [0, -0.2, 1.2], "target": [0, -1, 0.2],
    "cone_degrees": 12, "intensity": [6, 6, 6],
}  # fmt: skip
LIT_BY_GLOSS = of(hall, blinn(100, 0.1), blinn(100, 0.1), [{**LAMP, "intensity": [4] * 3}])

GLOSS = (
    Regime(
        "near mirror",
        "direct_to_indirect",
        "Reflections are made of gather samples, centimetres apart.",
        of(hall, metal(0.05), matt(0.6, 0.6, 0.6), [ON_THE_WALL]),
        0.45,
        {"gather_samples": 1024, "gloss_coefficients": 300},
        codes=("mirror_blurred",),
        mend=Mend("gather_samples 16384", {"gather_samples": 16384}),
    ),
    Regime(
        "caustic of brushed metal",
        "direct_to_indirect",
        "Samples send on all light diffusely, so what gloss throws is spread.",
        of(hall, metal(0.25), GREY, [ON_THE_FLOOR]),
        1.0,
        {"gather_samples": 4096},
        codes=("caustics_spread",),
        noise=0.25,
    ),
    Regime(
        "gloss seen in gloss, fixed materials",
        "direct_to_indirect",
        "Samples send on all light diffusely, so gloss looks matt in gloss.",
        LIT_BY_GLOSS,
        0.5,
        {"gather_samples": 4096},
        codes=("gloss_seen_as_matt",),
    ),
    Regime(
        "sharp gloss in four terms",
        "glossy_prt",
        "A lobe alone is no sum of a few products: highlights are wide and dim.",
        of(ball_alone, phong(100, 0.0), environment={"map": "studio", "background": False}),
        0.9,
        {"bounces": 0},
        codes=("too_glossy_for_terms",),
        mend=Mend("terms 16", {"terms": 16}),
        small=COARSER,
    ),
    Regime(
        "near mirror of few elements",
        "brdf_editing",
        "The lobe is narrower than the tents that it is a sum of.",
        of(floor_alone, blinn(20), lights=[{**POINT, "position": LAMP["position"]}]),
        0.2,
        {"bands": 16, "gather_samples": 1024},
        Edits(materials={"floor": {"exponent": 5000}}),
        ("too_sharp_for_bands",),
        Mend("bands 64", {"bands": 64}),
    ),
    Regime(
        "lobe between rays",
        "brdf_editing",
        "Few of a pixel's 256 rays fall into the lobe.",
        of(floor_alone, metal(0.3), environment={"map": [1, 1, 1]}),
        0.5,
        {"gather_samples": 1024, "bands": 256},
        Edits(materials={"floor": {"roughness": 0.1}}),
        ("lobe_between_rays",),
        Mend("lobe_exponent 5000", {"lobe_exponent": 5000}),
    ),
    Regime(
        "gloss seen in gloss",
        "brdf_editing",
        "The bounce that is seen has its lobe, those behind it are matt.",
        LIT_BY_GLOSS,
        0.5,
        {"bounces": 8, "gather_samples": 4096},
        codes=("gloss_seen_as_matt",),
        mend=Mend("second_bands 8", {"second_bands": 8}),
    ),
    Regime(
        "lobe narrower than a code's cell",
        "wavelet_brdf",
        "Its peak is spread over a cell.",
        of(floor_alone, phong(3000), lights=[{**POINT, "position": LAMP["position"]}]),
        0.8,
        codes=("lobe_narrower_than_cells",),
        mend=Mend("cells 64", {"cells": 64}),
    ),
)
