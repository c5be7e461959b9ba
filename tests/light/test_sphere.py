"""The ball: its irradiance at every distance, its rim, its inside."""

from __future__ import annotations

import math

import numpy as np
import pytest
from light.lights import emitted, illuminate, pdf, stratified

from engine.light.sphere import SphereLight

BALL = SphereLight(id="ball", position=(0, 2, 0), radius=0.5, intensity=(3.0, 3.0, 3.0))


@pytest.mark.parametrize("distance", [0.5 + 1e-6, 0.51, 0.7, 3.0, 1e3, 1e5])
def test_irradiance_is_that_of_a_point(distance: float) -> None:
    """E = π L R² / d² on a surface that faces it, as if it were a point, however near."""
    values = illuminate(BALL, (0, 2 - distance, 0), stratified(100, np.random.default_rng(1)))
    found = (values[:, 4] * values[:, 1]).mean()
    assert found == pytest.approx(math.pi * 3 * 0.25 / distance**2, rel=1e-3)
    np.testing.assert_allclose(values[:, 4], values[0, 4])  # all weigh the same


def test_half_a_ball_over_the_horizon() -> None:
    """E = L (σ - sin σ cos σ) where its centre lies in the surface's plane, R / sin σ away.

    That is twice the integral of sin² over the angle from the centre to the rim.
    """
    for sigma in (0.2, 0.8, 1.3):
        x = (0.5 / math.sin(sigma), 2, 0)
        values = illuminate(BALL, x, stratified(400, np.random.default_rng(2)))
        found = (values[:, 4] * np.maximum(values[:, 1], 0)).mean()
        expected = 3 * (sigma - math.sin(sigma) * math.cos(sigma))
        assert found == pytest.approx(expected, rel=2e-3)


def test_power() -> None:
    """It emits 4 π² R² L: through a sphere around it, too."""
    rng = np.random.default_rng(3)
    w = rng.normal(size=(500, 3))
    x = np.array(BALL.position) + 2 * w / np.linalg.norm(w, axis=1, keepdims=True)
    outwards = (x - BALL.position) / 2
    total = 0.0
    for u in stratified(12, rng):
        values = illuminate(BALL, x, u)
        total += (values[:, 4] * -(values[:, :3] * outwards).sum(axis=1)).mean() / 144
    assert total * 4 * math.pi * 4 == pytest.approx(4 * math.pi**2 * 0.25 * 3, rel=1e-3)


def test_rim_and_inside() -> None:
    assert emitted(BALL, (0.499, 0, 0), (0, 1, 0))[0, 0] == pytest.approx(2, abs=0.04)
    assert emitted(BALL, (0.501, 0, 0), (0, 1, 0))[0, 0] < 0
    assert emitted(BALL, (0, 0, 0), (0, -1, 0))[0, 0] < 0
    assert emitted(BALL, (0, 0, 0), (0, 1, 0))[0, 0] == pytest.approx(1.5)
    for x in ((0, 2, 0), (0.3, 2.2, 0)):
        assert illuminate(BALL, x, (0.3, 0.8))[0, 4] == 0
        assert pdf(BALL, x, (0, 1, 0))[0] == 0
        assert emitted(BALL, x, (0, 1, 0))[0, 0] < 0
