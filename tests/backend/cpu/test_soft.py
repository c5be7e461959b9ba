"""Lamps on matt surfaces by formula and visibility: exact in the open, right at a horizon."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter

from engine.backend.cpu.penumbra import changes_fast, mean_seen
from engine.light.table import AnyLight
from engine.methods.fixed_view import direct
from engine.methods.fixed_view.direct import (
    light_on_buffer,
    light_on_pixels,
)
from engine.methods.fixed_view.view import View
from engine.scene.build import build
from engine.scene.open import describe

SIZE = 32
# Half under the floor's horizon, and clear of it; each in front of the wall.
LAMPS: dict[str, dict[str, Any]] = {
    "area": {"target": [0, 0, -1], "width": 0.5, "height": 0.6},
    "disk": {"target": [0, 0, -1], "radius": 0.3},
    "sphere": {"radius": 0.3},
}


def lamp(kind: str, height: float) -> Any:
    data = {"id": kind, "type": kind, "position": [0.05, height, 0.4], "intensity": [3, 2, 1]}
    return TypeAdapter(AnyLight).validate_python({**data, **LAMPS[kind]})


@pytest.fixture(scope="module")
def view() -> View:
    """A floor and a wall, nothing between."""
    shape = {"shape": "rectangle", "size": [2, 2]}
    floor = {"rotate_degrees": [-90, 0, 0]}
    return View(
        build(
            describe(
                {
                    "camera": {
                        "position": [0, 1.2, 2.5],
                        "target": [0, 0.2, -0.5],
                        "fov_y_degrees": 40,
                        "width": SIZE,
                        "height": SIZE,
                    },
                    "lights": [],
                    "materials": {"white": {"type": "diffuse", "diffuse": [0.7, 0.6, 0.5]}},
                    "objects": [
                        {"name": "floor", "mesh": shape, "material": "white", "transform": floor},
                        {
                            "name": "wall",
                            "mesh": shape,
                            "material": "white",
                            "transform": {"translate": [0, 0.5, -1]},
                        },
                    ],
                }
            ),
            Path(),
        )
    )


def by_samples(view: View, light: Any, points: Any) -> np.ndarray:
    """From 32 x 32 points of the light in every one of ours."""
    grid = (np.indices((32, 32)).reshape(2, -1).T[None] + 0.5) / 32
    return direct._light(view.scene.rays, points, light, grid)[0]


@pytest.mark.parametrize("kind", LAMPS)
def test_in_the_open_it_is_exact(view: View, kind: str) -> None:
    """What all samples give, but for what those miss; and no two neighbours differ by chance."""
    light, points = lamp(kind, 0.6), view.buffer.centre
    whole = light_on_buffer(view.scene.rays, view.buffer, light)
    inside = points.matt.copy()
    inside[view.buffer.edge] = False
    expected = by_samples(view, light, points)
    off = np.linalg.norm((whole - expected)[inside]) / np.linalg.norm(expected[inside])
    assert off < 4e-3
    coarse = light_on_pixels(view.scene.rays, view.points(2), view.coarse_alike, SIZE // 2, light)
    every = np.arange(SIZE * SIZE).reshape(SIZE, SIZE)[::2, ::2].ravel()
    np.testing.assert_array_equal(coarse[inside[every]], whole[every][inside[every]])


@pytest.mark.parametrize("kind", LAMPS)
def test_a_lamp_that_the_horizon_cuts_loses_nothing(view: View, kind: str) -> None:
    """Half of it lies below the floor, which hides that half from the wall.

    The samples of a point may all lie there: others, that the floor can see, stand in for them.
    """
    light, points = lamp(kind, 0.0), view.buffer.centre
    expected = by_samples(view, light, points)
    floor = points.normal[:, 1] > 0.9
    assert expected[floor].mean() > 0.01
    inside = np.ones(len(points), np.bool_)
    inside[view.buffer.edge] = False
    found = light_on_buffer(view.scene.rays, view.buffer, light)
    for here, most in ((inside & floor, 0.01), (inside & points.matt & ~floor, 0.02)):
        assert found[here].sum() == pytest.approx(expected[here].sum(), rel=most)
        off = np.linalg.norm((found - expected)[here])
        assert off < 1.5 * most * np.linalg.norm(expected[here])


def test_tent_over_what_neighbours_see() -> None:
    """Every pixel of a block of 4 x 4 counts the same; borders and blind pixels have no weight."""
    width, height = 16, 12
    y, x = np.divmod(np.arange(width * height), width)
    alike = ((x < width - 1) * 1 + (y < height - 1) * 2).astype(np.uint8)
    rng = np.random.default_rng(1)
    pattern = rng.random((4, 4))[y % 4, x % 4]
    seen = np.column_stack([pattern, np.ones(len(x))]).astype(np.float32)
    every = np.arange(len(x), dtype=np.int32)
    found = mean_seen(seen, every, every, alike, width, 4)
    inner = (x >= 3) & (x < width - 3) & (y >= 3) & (y < height - 3)
    mean = pattern.reshape(height, width)[:4, :4].mean()
    np.testing.assert_allclose(found[inner], mean, rtol=1e-5)
    blind = rng.random(len(x)) < 0.3
    flat = np.where(blind[:, None], 0, [0.25, 0.5]).astype(np.float32)
    found = mean_seen(flat, every, every, alike, width, 4)
    np.testing.assert_allclose(found, 0.5, rtol=1e-6)


def test_where_it_changes_fast() -> None:
    """A ramp, and a pixel at a border of its surface."""
    width, height = 12, 9
    y, x = np.divmod(np.arange(width * height), width)
    alike = ((x < width - 1) * 1 + (y < height - 1) * 2).astype(np.uint8)
    every = np.arange(len(x), dtype=np.int32)
    inner = (x > 1) & (x < width - 2) & (y > 1) & (y < height - 2)
    for part in (x / 20, y / 20):
        for steepest, fast in ((0.06, False), (0.04, True)):
            found = changes_fast(part.astype(np.float32), every, alike, width, steepest)
            assert (found[inner] == fast).all()
    alike[(x == 5) & (y == 4)] = 2
    found = changes_fast(np.zeros(len(x), np.float32), every, alike, width, 0.1)
    assert set(zip(x[found & inner], y[found & inner], strict=True)) == {(5, 4), (6, 4)}
