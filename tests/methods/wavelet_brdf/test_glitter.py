"""How far off pixels are that show one facet of many, told from their neighbours."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.methods.fixed_view.frame_buffer import Points, no_points
from engine.methods.wavelet_brdf.glitter import scatter

SIDE = 200


def ground(normal: NDArray[np.float64]) -> Points:
    """Pixels of one thing with such normals, (h, w, 3) of any length."""
    unit = normal / np.linalg.norm(normal, axis=2, keepdims=True)
    points = no_points(unit.shape[0] * unit.shape[1])
    points.object[:] = 0
    return replace(points, normal=unit.reshape(-1, 3).astype(np.float32))


def noisy(off: float) -> NDArray[np.float32]:
    grey = 1 + off * np.random.default_rng(1).normal(size=(SIDE, SIDE, 1))
    return np.repeat(grey, 3, axis=2).astype(np.float32)


@pytest.mark.parametrize("off", [0.02, 0.3])
def test_facets_that_lie_anyhow_are_as_far_off_as_they_differ(off: float) -> None:
    bumps = np.random.default_rng(2).normal(0, 0.2, (SIDE, SIDE, 3))
    bumps[..., 2] += 1
    expected = off / np.sqrt(1 + off * off)
    assert scatter(ground(bumps), noisy(off)) == pytest.approx(expected, rel=0.15)


def test_what_bends_slowly_is_no_facet() -> None:
    """Whatever the picture does there."""
    y, x = np.mgrid[:SIDE, :SIDE] / SIDE * 2 - 1
    ball = np.stack([0.6 * x, 0.6 * y, np.sqrt(1 - 0.36 * (x * x + y * y))], axis=2)
    assert scatter(ground(ball), noisy(0.3)) < 0.01
    assert scatter(ground(np.broadcast_to([0.0, 0.6, 0.8], ball.shape)), noisy(0.3)) == 0


def test_an_edge_between_two_walls_is_none() -> None:
    walls = np.zeros((SIDE, SIDE, 3))
    walls[:, : SIDE // 2, 0], walls[:, SIDE // 2 :, 1] = 1, 1
    image = np.where(walls[..., :1] > 0, 0.2, 0.9).repeat(3, axis=2).astype(np.float32)
    assert scatter(ground(walls), image) == 0


def test_pictures_without_light_or_without_an_inside() -> None:
    points = ground(np.ones((2, 2, 3)))
    assert scatter(points, np.zeros((2, 2, 3), np.float32)) == 0
    assert scatter(points, np.ones((2, 2, 3), np.float32)) == 0
