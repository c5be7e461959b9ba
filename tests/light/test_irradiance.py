"""What a whole light gives a surface, by formula, is what its samples give; so is a glance."""

from __future__ import annotations

import numpy as np
import pytest
from light.lights import WIDE, glance, illuminate, irradiance, stratified
from scipy.integrate import quad

from engine.light.base import Light
from engine.numerics.angles import angle_over_sine

PLACES = 40


def unit(v: np.ndarray) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def sampled(light: Light, x: np.ndarray, n: np.ndarray, g: np.ndarray, side: int) -> np.ndarray:
    """(3,) by side² samples of `illuminate`."""
    values = illuminate(light, x, stratified(side, np.random.default_rng(1)))
    cosine, over = values[:, :3] @ n, values[:, :3] @ g
    return (values[:, 4:] * (np.maximum(cosine, 0) * (over > 0))[:, None]).mean(axis=0)


@pytest.mark.parametrize("light", WIDE, ids=lambda light: light.id)
def test_formula_against_samples(light: Light) -> None:
    """Over, under and across the horizon, near and far, behind and within."""
    rng = np.random.default_rng(2)
    centre = light.row()[:3].astype(float)
    x = rng.uniform(-1, 1, (PLACES, 3))
    x[: PLACES // 2] = centre + rng.normal(scale=0.5, size=(PLACES // 2, 3))
    n = unit(rng.normal(size=(PLACES, 3)))
    # Half of them look at it, or along it.
    towards = unit(centre - x) if centre.any() else np.tile(-light.row()[3:6], (PLACES, 1))
    n[::2] = unit(towards + 0.7 * n)[::2]
    n[1::4] = unit(np.cross(towards, n) + 0.1 * n)[1::4]
    n[-4:] = -light.row()[3:6] if light.row()[3:6].any() else n[-4:]
    found = irradiance(light, x, n, n)
    known = found[:, 0] >= 0
    # Of a disk alone the part over a horizon has no formula; from close by that is most of it.
    assert known.all() or (light.type == "disk" and known.mean() > 0.25)  # type: ignore[attr-defined]
    expected = np.array([sampled(light, *each, 300) for each in zip(x, n, n, strict=True)])
    scale = np.abs(expected).max()
    assert scale > 0
    off = np.abs(found - expected)[known]
    assert (off < 2e-3 * expected[known] + 2e-5 * scale).all()
    assert (found[known] > 0).any()


@pytest.mark.parametrize("light", WIDE, ids=lambda light: light.id)
def test_two_horizons(light: Light) -> None:
    """A light that the flat triangle hides in part has no formula; in whole it gives nothing."""
    rng = np.random.default_rng(3)
    x = rng.uniform(-1, 1, (PLACES, 3))
    n = unit(rng.normal(size=(PLACES, 3)))
    g = unit(n + 0.5 * rng.normal(size=(PLACES, 3)))
    found = irradiance(light, x, n, g)
    expected = np.array([sampled(light, *each, 200) for each in zip(x, n, g, strict=True)])
    known = found[:, 0] >= 0
    assert known.mean() > 0.25
    off = np.abs(found - expected)[known]
    assert (off < 3e-3 * expected[known] + 2e-5 * expected.max()).all()


@pytest.mark.parametrize("light", WIDE, ids=lambda light: light.id)
def test_a_glance_weighs_as_a_sample(light: Light) -> None:
    """Its mean is the same for any function of the direction."""
    u = stratified(300, np.random.default_rng(4))
    rng = np.random.default_rng(5)
    for x in rng.uniform(-1, 1, (12, 3)):
        a, b = illuminate(light, x, u), glance(light, x, u)
        assert np.isfinite(b).all()
        for k in (np.array([0.3, -0.5, 0.8]), np.array([-0.6, 0.2, 0.1])):
            mean = [(v[:, 4] * (1 + v[:, :3] @ k) ** 2).mean() for v in (a, b)]
            assert mean[1] == pytest.approx(mean[0], rel=5e-3, abs=1e-12)
            far = [(v[:, 4] * v[:, 3]).mean() for v in (a, b)]
            assert far[1] == pytest.approx(far[0], rel=5e-3, abs=1e-12)


def test_far_away_four_points_are_enough() -> None:
    """Where the formula of the rectangle changes, its value does not."""
    lamp = next(light for light in WIDE if light.id == "ceiling")
    reach = 4 * np.sqrt(2)
    for direction in unit(np.array([[0.0, -1, 0], [0.6, -0.5, 0], [0.3, -0.4, -0.8]])):
        for lean in ((0, 0, 0), (0.3, 0, -0.4)):
            n = unit(-direction + lean)
            near, far = (
                irradiance(lamp, np.array([0, 1, 0]) + k * reach * direction, n, n)[0, 0] * k**2
                for k in (1 - 1e-6, 1 + 1e-6)
            )
            assert far == pytest.approx(near, rel=3e-4)


def test_irradiance_of_a_ball_by_quadrature() -> None:
    """Across the horizon, for the sun and every ball: the integral over slices of the cone."""
    sun = next(light for light in WIDE if light.id == "soft sun")
    axis, half = -sun.row()[3:6].astype(float), np.radians(5)
    for over in (-0.99, -0.5, 0.0, 0.2, 0.7, 0.999, 1.3):
        elevation = over * half
        n = unit(np.cross(axis, [0.2, 0.3, 1])) * np.cos(elevation) + axis * np.sin(elevation)

        def slice_at(h: float, elevation: float = elevation) -> float:
            """Of the cone at elevation h over the horizon: sin h cos h times its width."""
            c = (np.cos(half) - np.sin(elevation) * np.sin(h)) / (np.cos(elevation) * np.cos(h))
            return 2 * np.arccos(np.clip(c, -1, 1)) * np.sin(h) * np.cos(h)

        expected, _ = quad(slice_at, max(0, elevation - half), elevation + half, epsabs=1e-12)
        found = irradiance(sun, (0, 0, 0), n, n)[0] / sun.row()[6:9]
        np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-9)


def test_angle_over_sine() -> None:
    c = np.linspace(-0.99999, 0.99999, 4001)
    found = np.array([angle_over_sine(v) for v in c])
    np.testing.assert_allclose(found, np.arccos(c) / np.sqrt(1 - c * c), rtol=3e-8)
    assert angle_over_sine(1.0) == pytest.approx(1, abs=3e-8)
