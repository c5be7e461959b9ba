"""Every kind of light in a fixed view: the picture and the gather cloud against the path tracer."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from engine.light.table import LIGHTS
from engine.methods.fixed_view.cloud import build_cloud
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.view import View
from engine.reference import render
from engine.scene.build import build
from engine.scene.open import describe
from engine.scene.scene import Scene

SIZE, BLOCK = 64, 4
TALL = {"position": [0.3, 1.5, 0.4], "target": [-0.1, 0, -0.2]}
KINDS: dict[str, dict[str, Any]] = {
    "point": {"position": [0.3, 1.5, 0.4]},
    "spot": {**TALL, "cone_degrees": 40},
    "area": {**TALL, "width": 0.5, "height": 0.3},
    "disk": {**TALL, "radius": 0.3},
    "sphere": {"position": [0.3, 1.5, 0.4], "radius": 0.2},
    "distant": {"direction": [-0.3, -1, -0.2]},
    "sun": {"direction": [-0.3, -1, -0.2], "diameter_degrees": 5},
    "projector": {**TALL, "fov_y_degrees": 60, "image": "leaves"},
    "uberlight": {**TALL, "cut_off": 1.7, "far_edge": 0.5, "roundness": 0.5, "edge": 0.2},
}


def scene(kind: str) -> Scene:
    """A floor, a wall and a block, open above; the lamps themselves are not in the picture."""
    light = {"id": kind, "type": kind, "intensity": [1, 2, 4], **KINDS[kind]}
    shape = {"shape": "rectangle", "size": [2, 2]}
    return build(
        describe(
            {
                "camera": {
                    "position": [0.1, 0.9, 2.2],
                    "target": [0, 0.1, 0],
                    "fov_y_degrees": 40,
                    "width": SIZE,
                    "height": SIZE,
                },
                "lights": [light],
                "materials": {"white": {"type": "diffuse", "diffuse": [0.7, 0.7, 0.7]}},
                "objects": [
                    {
                        "name": "floor",
                        "mesh": shape,
                        "material": "white",
                        "transform": {"rotate_degrees": [-90, 0, 0]},
                    },
                    {
                        "name": "wall",
                        "mesh": shape,
                        "material": "white",
                        "transform": {"translate": [0, 0.5, -1]},
                    },
                    {
                        "name": "block",
                        "mesh": {"shape": "box", "size": [0.4, 0.4, 0.4]},
                        "material": "white",
                        "transform": {"translate": [-0.3, 0.2, 0]},
                    },
                ],
            }
        ),
        Path(),
    )


def test_every_kind_is_here() -> None:
    assert set(KINDS) == {kind.model_fields["type"].default for kind in LIGHTS}


@pytest.mark.parametrize("kind", KINDS)
def test_picture_against_the_path_tracer(kind: str) -> None:
    """Soft shadows, images and slices alike, but for what ends within a pixel."""
    made = scene(kind)
    picture = View(made).direct(made.lights, 1).reshape(SIZE, SIZE, 3)
    truth = render(made, samples=96, seed=1, max_bounces=1)

    def blocks(image: np.ndarray) -> np.ndarray:
        n = SIZE // BLOCK
        return image.reshape(n, BLOCK, n, BLOCK, 3).mean(axis=(1, 3))

    off = blocks(picture) - blocks(truth.image)
    assert np.linalg.norm(off) < 0.04 * np.linalg.norm(blocks(truth.image))
    assert picture.mean() == pytest.approx(truth.image.mean(), rel=0.015)


def test_the_cloud_sees_the_image_at_its_own_size() -> None:
    """Fewer gather samples each look up a smaller image: the mean stays, the detail goes."""
    made = scene("projector")
    view = View(made)
    light = made.lights[0].model_copy(update={"image": "chart"})
    found = []
    for count in (256, 4096):
        cloud = build_cloud(made, view.points(1), count, 20.0, "uniform", 1)
        assert cloud.points.size[0] == pytest.approx(np.sqrt(cloud.area[0]), rel=1e-6)
        point = light_on_points(made.rays, cloud.points, light)
        sharp = cloud.points.take(slice(None))
        sharp.size[:] = 0
        found.append((light_on_points(made.rays, sharp, light), point))
        assert found[-1][0].sum() == pytest.approx(found[-1][1].sum(), rel=0.1)
    # How far the look-up at the sample's size is from the one at a point: less for more samples.
    far = [np.linalg.norm(a - b) / np.linalg.norm(a) for a, b in found]
    assert 0.02 < far[1] < 0.6 * far[0]
