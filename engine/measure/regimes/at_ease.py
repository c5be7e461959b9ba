"""Ordinary scenes under ordinary edits at the methods' own settings: right, and nothing is said."""

from __future__ import annotations

from typing import Any

from engine.measure.regimes.regime import AS_IT_IS, BUDGET, NOISE, MakeScene, Regime
from engine.measure.regimes.stages import (
    BEHIND,
    COARSER,
    GREY,
    LAMP,
    LIT,
    Described,
    ball_alone,
    ball_on_floor,
    blinn,
    floor_alone,
    hall,
    of,
    phong,
    room,
)
from engine.scene.builtin.pieces import matt
from engine.scene.edits import Edits

SOFT: Described = {**LAMP, "position": [0.3, 0.8, 0.1], "width": 0.8, "height": 0.8}
FEWER: dict[str, Any] = {"gather_samples": 4096}
MATT_ROOM = of(room, wall=matt(0.6, 0.5, 0.3), lights=[BEHIND])
GLOSSY_FLOOR = of(hall, blinn(30, 0.3), matt(0.7, 0.3, 0.2), [{**LAMP, "intensity": [4] * 3}])
STUDIO = of(ball_on_floor, GREY, GREY, environment={"map": "studio"})
SATIN = of(ball_on_floor, phong(6, 0.3, 0.2), GREY, environment={"map": "studio"})
PLASTIC = of(floor_alone, {"type": "measured", "file": "plastic"}, lights=[LIT])

TURNED = Edits(environment={"rotation_degrees": 70})
ELSEWHERE = Edits(camera={"position": [2, 1.5, 2]})


def _easy(name: str, method: str, scene: MakeScene, edit: Edits = AS_IT_IS, **small: Any) -> Regime:
    # Light of a single lamp is hardly noisy, so that a better reference costs nothing.
    noise = 0.02 if method == "wavelet_brdf" else NOISE
    return Regime(
        name, method, "Nothing breaks.", scene, BUDGET, {}, edit, small=small, noise=noise
    )


def _lights(**change: object) -> Edits:
    return Edits(lights=[{"id": "lamp", **change}])


AT_EASE = (
    _easy("matt room", "direct_to_indirect", MATT_ROOM, **FEWER),
    _easy(
        "its lamp moved",
        "direct_to_indirect",
        MATT_ROOM,
        _lights(position=[-0.6, 0.5, 0.8]),
        **FEWER,
    ),
    _easy(
        "its lamp dimmed and red",
        "direct_to_indirect",
        MATT_ROOM,
        _lights(intensity=[2, 0.5, 0.2]),
        **FEWER,
    ),
    _easy("white room", "direct_to_indirect", of(room, wall=matt(0.9, 0.9, 0.9)), **FEWER),
    _easy("glossy floor among matt walls", "direct_to_indirect", GLOSSY_FLOOR, **FEWER),
    _easy(
        "studio turned, fixed view",
        "direct_to_indirect",
        STUDIO,
        TURNED,
        **FEWER,
    ),
    _easy("studio", "glossy_prt", STUDIO, **COARSER),
    _easy(
        "studio turned",
        "glossy_prt",
        STUDIO,
        TURNED,
        **COARSER,
    ),
    _easy(
        "studio from elsewhere",
        "glossy_prt",
        STUDIO,
        ELSEWHERE,
        **COARSER,
    ),
    _easy("satin ball in the studio", "glossy_prt", SATIN, **COARSER),
    _easy(
        "matt room painted",
        "brdf_editing",
        MATT_ROOM,
        Edits(materials={"wall": {"diffuse": [0.1, 0.2, 0.15]}}),
        **FEWER,
    ),
    _easy(
        "glossy floor, other gloss",
        "brdf_editing",
        GLOSSY_FLOOR,
        Edits(materials={"floor": {"exponent": 60}}),
        **FEWER,
    ),
    _easy(
        "matt floor made glossy",
        "brdf_editing",
        of(hall, GREY, matt(0.7, 0.3, 0.2), [SOFT]),
        Edits(materials={"floor": blinn(50, 0.3)}),
        **FEWER,
    ),
    _easy("plastic floor", "wavelet_brdf", PLASTIC),
    _easy(
        "plastic floor, its lamp moved", "wavelet_brdf", PLASTIC, _lights(position=[-0.8, 0.7, 1.3])
    ),
    _easy(
        "plastic floor from afar",
        "wavelet_brdf",
        PLASTIC,
        Edits(camera={"position": [0, 1.6, 4], "fov_y_degrees": 8}),
    ),
    _easy("glossy ball", "wavelet_brdf", of(ball_alone, phong(40), lights=[LIT])),
)
