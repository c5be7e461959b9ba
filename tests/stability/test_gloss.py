"""Gloss that the transfer cannot carry: how wide lobes are, and how much is a caustic."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from methods.scenes import POINT, camera, rectangle, scene

from engine.brdf.phong import Phong
from engine.brdf.table import INDEX
from engine.methods.base import Frame
from engine.methods.direct_to_indirect import Transfer
from engine.methods.direct_to_indirect.gloss_limits import lobe_width
from engine.scene.edits import Edits
from engine.scene.scene import Scene

SIZE = 32
Make = Callable[..., Transfer]


def part(frame: Frame) -> float:
    """Of the light that is said to leave gloss in a narrow lobe; 0 where nothing is said."""
    said = [w.message for w in frame.warnings if w.code == "caustics_spread"]
    return float(said[0].split(" %")[0]) / 100 if said else 0.0


def metal(roughness: float, reflectance: float = 0.9) -> dict[str, Any]:
    return {
        "type": "ggx",
        "diffuse": [0] * 3,
        "specular": [reflectance] * 3,
        "roughness": roughness,
    }


def test_lobes_are_as_wide_as_they_are() -> None:
    """A cosine lobe about the mirror direction against its integral; a base does not count."""
    exponents = (8.0, 60.0, 1000.0)
    phong = [Phong(diffuse=(0.7,) * 3, specular=(0.1,) * 3, exponent=n).row() for n in exponents]
    model = np.full(len(phong), INDEX[Phong], np.int32)
    found = lobe_width(model, np.array(phong, np.float32))
    angle = np.linspace(0, np.pi / 2, 20001)
    for n, width in zip(exponents, found, strict=True):
        weight = np.cos(angle) ** n * np.sin(angle)
        # The true lobe is cut at the horizon and weighed by the cosine there: less so if sharp.
        expected = np.sqrt((weight * angle**2).sum() / weight.sum())
        assert width == pytest.approx(expected, rel=0.12 if n > 10 else 0.25)


def cube_on(floor: dict[str, Any], light: dict[str, Any]) -> Scene:
    """A closed cube of albedo 0.5 on a floor of something."""
    sides = {
        "floor": ([0, -1, 0], [-90, 0, 0]),
        "ceiling": ([0, 1, 0], [90, 0, 0]),
        "back": ([0, 0, -1], [0, 0, 0]),
        "front": ([0, 0, 1], [0, 180, 0]),
        "left": ([-1, 0, 0], [0, 90, 0]),
        "right": ([1, 0, 0], [0, -90, 0]),
    }
    return scene(
        camera=camera(SIZE, position=[0.1, -0.3, 0.9], target=[0, 0.2, 0]),
        lights=[light],
        materials={"floor": floor, "grey": {"type": "diffuse", "diffuse": [0.5] * 3}},
        objects=[
            {**rectangle(n, [2, 2], t, r), "material": "floor" if n == "floor" else "grey"}
            for n, (t, r) in sides.items()
        ],
    )


@pytest.mark.parametrize(("roughness", "caustic"), [(0.1, True), (0.3, True), (0.8, False)])
def test_the_share_of_caustics_in_a_cube(make: Make, roughness: float, caustic: bool) -> None:
    """From the middle of a cube each face gets a sixth: floor albedo by that of all six faces."""
    product = make(
        cube_on(metal(roughness, 0.8), {**POINT, "position": [0, 0, 0]}), gather_samples=1024
    )
    floor = product.cloud.albedo[product.cloud.points.object == 0].mean()
    share = part(product.relight(Edits()))
    assert share == pytest.approx(floor / (floor + 5 * 0.5) if caustic else 0, abs=0.01)
    matt = {"type": "diffuse", "diffuse": [0.8] * 3}
    plain = make(cube_on(matt, {**POINT, "position": [0, 0, 0]}), gather_samples=1024)
    assert part(plain.relight(Edits())) == 0
