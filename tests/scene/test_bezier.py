"""Bézier splines and the shapes made of them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from engine.scene import shapes
from engine.scene.bezier import parameters, spline, surface
from engine.scene.builtin.pieces import rounded
from engine.scene.part import Part

ANY: TypeAdapter[Any] = TypeAdapter(shapes.AnyShape)
POINTS = np.random.default_rng(0).normal(size=(10, 3))


def make(**shape: Any) -> Part:
    return shapes.make(ANY.validate_python(shape))


def by_halving(points: np.ndarray, t: float) -> np.ndarray:
    """De Casteljau's construction."""
    piece = min(int(t), len(points) // 3 - 1)
    left = points[3 * piece : 3 * piece + 4]
    while len(left) > 1:
        left = left[:-1] + (t - piece) * (left[1:] - left[:-1])
    return left[0]


def test_splines_are_what_de_casteljau_constructs() -> None:
    t = parameters(len(POINTS), 7)
    assert (t[0], t[-1], len(t)) == (0, 3, 22)
    expected = [by_halving(POINTS, float(x)) for x in t]
    np.testing.assert_allclose(spline(POINTS, t), expected, atol=1e-12)


def test_they_pass_through_every_third_point_to_the_last_digit() -> None:
    assert np.array_equal(spline(POINTS, np.arange(4.0)), POINTS[::3])


def test_slopes_are_those_of_the_curve() -> None:
    t, h = np.linspace(0.01, 2.98, 41), 1e-6
    numeric = (spline(POINTS, t + h) - spline(POINTS, t - h)) / (2 * h)
    np.testing.assert_allclose(spline(POINTS, t, 1), numeric, atol=1e-6)


def test_a_surface_is_a_spline_of_splines() -> None:
    net = np.random.default_rng(1).normal(size=(7, 4, 3))
    v, u, h = np.array([0.3, 1.7]), np.array([0.2, 0.9]), 1e-6
    rows = np.array([[by_halving(net[:, j], x) for j in range(4)] for x in v])
    expected = [[by_halving(row, x) for x in u] for row in rows]
    np.testing.assert_allclose(surface(net, v, u), expected, atol=1e-12)
    numeric = (surface(net, v, u + h, v_order=1) - surface(net, v, u - h, v_order=1)) / (2 * h)
    np.testing.assert_allclose(surface(net, v, u, 1, 1), numeric, atol=1e-6)


def test_a_revolution_has_an_edge_only_where_its_profile_has_one() -> None:
    sharp = rounded((0, 0, 0), (1, 0, 0), (1, 2, 0), (0, 2, 0))
    part = make(shape="revolution", profile=sharp, segments=2, sides=4)
    assert part.normals is not None
    levels = {tuple(np.round(n, 9)) for n in part.normals}
    assert len(levels) == 6  # up, down, four sides: those of a cylinder
    soft = rounded((0, 0, 0), (1, 0, 0.2), (1, 2, 0.2), (0, 2, 0))
    part = make(shape="revolution", profile=soft, segments=4, sides=8)
    assert part.normals is not None
    # Where curves meet their vertices lie in one place and agree.
    _, which = np.unique(np.round(part.positions, 9) + 0.0, axis=0, return_inverse=True)
    which = which.reshape(-1)
    for place in np.unique(which):
        here = part.normals[which == place]
        assert (here @ here[0]).min() > 1 - 1e-9 or len(here) > 4  # poles are level besides
    assert len(np.unique(which)) < len(part.positions)


def test_rounded_corners_are_close_to_circles() -> None:
    path = np.array(rounded((0, 0, 0), (1, 0, 0.25), (1, 1, 0)))
    arc = spline(path[3:7], np.linspace(0, 1, 33))
    assert np.hypot(arc[:, 0] - 0.75, arc[:, 1] - 0.25) == pytest.approx(0.25, rel=3e-4)


def test_a_bent_tube_keeps_its_radius() -> None:
    points = [(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 2, 1)]
    part = make(shape="tube", points=points, radius=0.1, segments=64, sides=12)
    curve = spline(np.array(points, float), np.linspace(0, 1, 4001))
    side = part.positions[: 13 * 65]
    near = np.linalg.norm(side[:, None] - curve[None, ::8], axis=2).min(axis=1)
    assert near == pytest.approx(0.1, rel=2e-3)
    assert part.normals is not None
    slopes = np.tile(spline(np.array(points, float), np.arange(65) / 64, 1), (13, 1))
    assert np.abs(np.sum(part.normals[: 13 * 65] * slopes, axis=1)).max() < 1e-12


@pytest.mark.parametrize(
    ("points", "what"),
    [
        ([(0, 0), (1, 0), (1, 1), (2, 2), (3, 3)], "5 points"),
        ([(0, 0), (0, 0), (1, 1), (2, 2)], "points 0 and 1 are the same"),
        ([(0, 0), (1, 1), (2, 2), (2, 2)], "points 2 and 3 are the same"),
        ([(0, 0), (1, 1), (-2, 2), (2, 2)], "greater than or equal to 0"),
    ],
)
def test_what_is_no_profile(points: list[tuple[float, float]], what: str) -> None:
    with pytest.raises(ValidationError, match=what):
        make(shape="revolution", profile=points)


def test_a_ball_of_revolution_and_a_straight_tube_hold_their_volume() -> None:
    k = 4 / 3 * (math.sqrt(2) - 1)
    ball = [(0, -1), (k, -1), (1, -k), (1, 0), (1, k), (k, 1), (0, 1)]
    for part, expected in (
        (make(shape="revolution", profile=ball, segments=24, sides=96), 4 / 3 * math.pi),
        (make(shape="tube", points=[(0, 0, k) for k in range(4)], radius=1, sides=96), 3 * math.pi),
    ):
        c = part.positions[part.triangles] + [5, -3, 2]
        volume = np.sum(c[:, 0] * np.cross(c[:, 1], c[:, 2])) / 6
        assert volume == pytest.approx(expected, rel=0.004)
