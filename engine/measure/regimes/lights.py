"""Lights that are too near, too narrow, too small, too many or of the wrong kind."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from engine.measure.probes import many_lights
from engine.measure.regimes.regime import Mend, Regime
from engine.measure.regimes.stages import (
    COARSER,
    GREY,
    LAMP,
    LIT,
    POINT,
    Described,
    ball_alone,
    ball_on_floor,
    blinn,
    cornell,
    floor_alone,
    metal,
    of,
    room,
    with_picture,
)
from engine.scene.edits import Edits
from engine.scene.scene import Scene

UP = {"target": [0.1, 0.6, -0.6], "position": [-0.2, -0.5, 0.6]}  # sees no floor
EIGHT = [(30, 20 + 20 * k) for k in range(8)]
CONE = np.radians(5)
SPOT: Described = {
    **POINT, "type": "spot", "position": [0.2, 0.6, 0], "target": [0.2, -1, 0],
    "cone_degrees": 5, "penumbra_degrees": 0, "intensity": [200, 160, 120],
}  # fmt: skip


def seen_as_disk(albedo: float = 0.5) -> Edits:
    """What the floor of that albedo makes of SPOT: an even disk that emits as much as it reflects.

    Path tracing finds so small a patch seldom by chance.
    """
    radius = 1.6 * np.tan(CONE)
    # Flux 2π I (1 - cos) albedo = π L π r², L the disk's radiance.
    part = 2 * albedo * (1 - np.cos(CONE)) / (np.pi * radius**2)
    disk = {
        "id": "disk", "type": "disk", "position": [0.2, -1 + 1e-3, 0], "target": [0.2, 1, 0],
        "radius": radius, "intensity": [part * i for i in SPOT["intensity"]],
    }  # fmt: skip
    return Edits(lights=[{"id": "lamp", "enabled": False}, disk])


def close_to_floor(
    x: float, z: float, height: float = 1e-3, albedo: float = 0.5
) -> tuple[Edits, Edits]:
    """A point light so high above a place of the floor of a room, and what shines so.

    Path tracing does not find the square millimetres below the light. But half of the light goes
    there, and the floor reflects it as a Lambert emitter so small that a disk of 2 cm stands for
    it; the other half is a lamp that shines up.
    """
    intensity = POINT["intensity"]
    above = {"position": [x, -1 + height, z], "target": [x, 1, z]}
    up = {"id": "up", "type": "spot", **above, "cone_degrees": 90, "penumbra_degrees": 0}
    # 2π I albedo = π L π r², L the disk's radiance.
    radiance = [2 * albedo * i / (np.pi * 0.02**2) for i in intensity]
    disk = {"id": "disk", "type": "disk", **above, "radius": 0.02, "intensity": radiance}
    disk["position"] = [x, -1 + 1e-3, z]
    return (
        Edits(lights=[{"id": "lamp", "position": [x, -1 + height, z]}]),
        Edits(lights=[{"id": "lamp", "enabled": False}, {**up, "intensity": intensity}, disk]),
    )


def suns(*texels: tuple[int, int], even: float = 0.0) -> np.ndarray:
    """(128, 256, 3): a map of even radiance but for suns of 2 x 2 texels at (row, column)."""
    image = np.full((128, 256, 3), even, np.float32)
    for row, column in texels:
        image[row : row + 2, column : column + 2] = 2000 / len(texels)
    return image


def shines_along(texel: tuple[int, int]) -> list[float]:
    """Where the light of a texel (row, column) of such a map travels."""
    theta, phi = ((part + 1) * np.pi / 128 for part in texel)
    phi -= np.pi
    return [-np.sin(theta) * np.sin(phi), -np.cos(theta), np.sin(theta) * np.cos(phi)]


def under_eight_suns(side: int, floor: Described = GREY) -> Scene:
    """A matt ball on a floor under an even sky with eight suns of 2 x 2 texels."""

    def make(folder: Path) -> Scene:
        sky = {"map": "picture.exr"}
        return ball_on_floor(side, GREY, floor, folder=folder, environment=sky)

    return with_picture(make, suns(*EIGHT, even=0.1))


def ball_under_a_sun(side: int) -> Scene:
    """A matt ball alone, which shows the sun its side."""

    def make(folder: Path) -> Scene:
        return ball_alone(side, GREY, folder, environment={"map": "picture.exr"})

    return with_picture(make, suns((30, 230)))


def many(side: int) -> Scene:
    """The Cornell box under two hundred points."""
    box = cornell(side)
    return box.with_lights(many_lights(box, 200, seed=3))


SUNS = Edits(
    environment={"map": [0.1] * 3},
    lights=[
        {"id": f"sun {k}", "type": "sun", "direction": way, "intensity": [0.4] * 3}
        for k, way in enumerate(map(shines_along, EIGHT))
    ],
)
BETWEEN, BESIDE = (-0.286, -0.242), (-0.28, 0.37)  # samples, and one of them

LIGHTS = (
    Regime(
        "lamp 1 mm from a wall",
        "direct_to_indirect",
        "What falls on the wall lands between gather samples, and half of the light is missed.",
        of(room, **UP),
        0.45,
        {"gather_samples": 4096},
        close_to_floor(*BETWEEN)[0],
        ("light_between_samples",),
        Mend("the lamp two spacings off the wall", edit=close_to_floor(*BETWEEN, 0.15)[0]),
        seen_as=close_to_floor(*BETWEEN)[1],
    ),
    Regime(
        "lamp 1 mm from a gather sample",
        "direct_to_indirect",
        "The sample stands for a piece of wall that does not get nearly as much.",
        of(room, **UP),
        4.0,
        {"gather_samples": 4096},
        close_to_floor(*BESIDE)[0],
        ("light_between_samples",),
        Mend("the lamp two spacings off the wall", edit=close_to_floor(*BESIDE, 0.15)[0]),
        seen_as=close_to_floor(*BESIDE)[1],
    ),
    Regime(
        "narrow cone on few samples",
        "direct_to_indirect",
        "A spot of 5 degrees falls on one of 256 samples or on none.",
        of(room, lights=[SPOT], **UP),
        1.05,
        {"gather_samples": 256},
        codes=("light_between_samples",),
        mend=Mend("gather_samples 16384", {"gather_samples": 16384}),
        seen_as=seen_as_disk(0.5),
    ),
    Regime(
        "eight suns",
        "direct_to_indirect",
        "Three suns of a map become lights of their own; rays are too few for the others.",
        under_eight_suns,
        0.12,
        {"gather_samples": 4096},
        codes=("environment_too_sharp",),
        mend=Mend("lights of type sun in their place", edit=SUNS),
    ),
    Regime(
        "sun of four texels",
        "glossy_prt",
        "128 wavelets are some five degrees wide.",
        ball_under_a_sun,
        0.05,
        mend=Mend("coefficients 1024, no clusters", {"coefficients": 1024, "cluster_error": 0}),
    ),
    Regime(
        "sun of four texels that grazes",
        "glossy_prt",
        "The side that turns from the sun has little of its light, and shows twice as much.",
        ball_under_a_sun,
        0.3,
        edit=Edits(environment={"rotation_degrees": 150}),
        mend=Mend("coefficients 1024, no clusters", {"coefficients": 1024, "cluster_error": 0}),
    ),
    Regime(
        "lamps beside an environment",
        "glossy_prt",
        "Transport is from infinity alone: lamps do not shine.",
        of(
            ball_on_floor,
            GREY,
            GREY,
            environment={"map": [0.2] * 3},
            lights=[{**POINT, "position": [0.9, 1.2, 0.7]}],
        ),
        0.3,
        codes=("lights_left_out",),
        mend=Mend("direct_to_indirect", {"gather_samples": 4096}, "direct_to_indirect"),
        small=COARSER,
    ),
    Regime(
        "lamp mirrored sharply",
        "brdf_editing",
        "A lamp is taken as 64 points, and a mirror shows them.",
        of(floor_alone, blinn(100_000), lights=[LAMP]),
        1.3,
        {"bands": 256, "view_rays": 16, "gather_samples": 1024},
        codes=("lamp_seen_as_points",),
    ),
    Regime(
        "lamp mirrored sharply, fixed view",
        "direct_to_indirect",
        "A pixel takes eight points of a lamp, and a mirror shows them.",
        of(floor_alone, metal(0.05), lights=[LAMP]),
        6.0,
        {"gather_samples": 256},
        codes=("lamp_seen_as_points",),
    ),
    Regime(
        "environment behind lamps",
        "wavelet_brdf",
        "Codes are looked up for lamps alone: the environment is seen and does not shine.",
        of(
            ball_alone,
            GREY,
            environment={"map": [0.5] * 3, "background": False},
            lights=[LIT],
        ),
        0.85,
        codes=("environment_left_out",),
        mend=Mend("direct_to_indirect", {"gather_samples": 1024}, "direct_to_indirect"),
    ),
    Regime(
        "small bright patch",
        "direct_to_indirect",
        "Few of a pixel's 233 rays meet it, so neighbours differ.",
        cornell,
        0.12,
        {"gather_samples": 16384},
        Edits(
            lights=[
                {"id": "ceiling", "enabled": False},
                {
                    **POINT,
                    "id": "key",
                    "type": "spot",
                    "cone_degrees": 14.0,
                    "position": [0.32, 0.45, 0.2],
                    "target": [0.37, 0.33, 0.35],
                },
            ]
        ),
        mend=Mend("view_rays 2584", {"view_rays": 2584}),
        noise=0.1,
    ),
    Regime(
        "two hundred lamps",
        "direct_to_indirect",
        "Each of them casts shadows that end within pixels.",
        many,
        0.05,
        {"gather_samples": 16384},
        small={"gather_samples": 4096},
        noise=0.1,
    ),
)
