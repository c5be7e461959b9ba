"""The sun: its irradiance whatever its size, its edge, its place in the picture."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from light.lights import emitted, illuminate, stratified

from engine.light.sun import SunLight
from engine.methods.fixed_view.preview import DirectPreview
from engine.reference import render
from engine.scene.build import build
from engine.scene.edits import Edits
from engine.scene.open import describe


@pytest.mark.parametrize("diameter", [0.01, 0.53, 10.0, 90.0])
def test_irradiance_is_the_intensity(diameter: float) -> None:
    """On a surface that faces it and, times the cosine, on one that is tilted: E is a vector."""
    sun = SunLight(
        id="s", direction=(1, -2, 0.5), diameter_degrees=diameter, intensity=(4.0, 4.0, 4.0)
    )
    axis = -np.array([1, -2, 0.5]) / math.sqrt(5.25)
    tilted = axis + 0.3 * np.array([0, 0.5, 2]) / math.sqrt(4.25)  # all of it above the horizon
    tilted /= np.linalg.norm(tilted)
    for x in ((0, 0, 0), (1e4, -7, 3)):
        values = illuminate(sun, x, stratified(100, np.random.default_rng(1)))
        assert (values[:, 3] == 1e30).all()
        for normal in (axis, tilted):
            found = (values[:, 4] * (values[:, :3] @ normal)).mean()
            assert found == pytest.approx(4 * axis @ normal, rel=2e-4)


def test_edge() -> None:
    sun = SunLight(id="s", direction=(0, 0, 1), diameter_degrees=2.0)
    for degrees, seen in ((0, True), (0.999, True), (1.001, False), (180, False)):
        t = math.radians(degrees)
        distance = emitted(sun, (5, 5, 5), (math.sin(t), 0, -math.cos(t)))[0, 0]
        assert (distance > 0) == seen


def test_in_the_picture() -> None:
    """The sky behind it is in no way, a wall is; the preview and the reference see the same."""
    scene = build(
        describe(
            {
                "camera": {
                    "position": [0, 0, 0],
                    "target": [0, 0, -1],
                    "fov_y_degrees": 40,
                    "width": 32,
                    "height": 32,
                },
                "lights": [
                    {
                        "id": "sun",
                        "type": "sun",
                        "direction": [0, 0, 1],
                        "diameter_degrees": 16,
                        "intensity": [1, 2, 3],
                    }
                ],
                "materials": {"white": {"type": "diffuse", "diffuse": [0.5, 0.5, 0.5]}},
                "objects": [
                    {
                        "name": "wall",
                        "mesh": {"shape": "box", "size": [10, 10, 0.1]},
                        "material": "white",
                        "transform": {"translate": [-5, 0, -3]},
                    }
                ],
            }
        ),
        Path(),
    )
    picture = DirectPreview(scene).relight(Edits()).image
    radiance = 1 / (math.pi * math.sin(math.radians(8)) ** 2)
    assert picture[16, 18, 0] == pytest.approx(radiance, rel=1e-5)
    assert picture[16, 31, 0] == 0
    assert (picture[:, :15] == 0).all()  # the wall, from behind
    half = math.pi * (math.tan(math.radians(8)) / math.tan(math.radians(20)) * 16) ** 2 / 2
    assert (picture[..., 0] / radiance).sum() == pytest.approx(half, rel=0.03)
    truth = render(scene, samples=64, seed=1)
    assert picture.mean() == pytest.approx(truth.image.mean(), rel=0.03)
