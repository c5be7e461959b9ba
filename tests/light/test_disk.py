"""The disk against its form factors, and how even the weights of its samples are."""

from __future__ import annotations

import math

import numpy as np
import pytest
from light.lights import emitted, illuminate, stratified

from engine.light.disk import DiskLight
from engine.methods.fixed_view.direct import light_samples

LAMP = DiskLight(
    id="lamp", position=(0, 2, 0), target=(0, 0, 0), radius=0.6, intensity=(7.0, 7.0, 7.0)
)
GRID = light_samples(LAMP, 64)[0]


def irradiance(x: tuple[float, float, float], u: np.ndarray, normal: tuple = (0, 1, 0)) -> float:
    values = illuminate(LAMP, x, u)
    return float((values[:, 4] * np.maximum(values[:, :3] @ np.array(normal), 0)).mean())


def parallel(offset: float, height: float) -> float:
    """E on a parallel plane, π L F with F = (1 - (Z - 2 R²) / √(Z² - 4 R²)) / 2.

    R = radius / offset, Z = 1 + (height / offset)² + R² (Howell, *A Catalog of Radiation Heat
    Transfer Configuration Factors*, B-13); R² / (R² + height²) on the axis.
    """
    if offset == 0:
        return math.pi * 7 * 0.36 / (0.36 + height**2)
    r2, h2 = (0.6 / offset) ** 2, (height / offset) ** 2
    z = 1 + h2 + r2
    return math.pi * 7 * (1 - (z - 2 * r2) / math.sqrt(z * z - 4 * r2)) / 2


@pytest.mark.parametrize("height", [1e-4, 0.01, 0.3, 1.0, 5.0, 300.0])
@pytest.mark.parametrize("offset", [0.0, 0.2, 0.59, 0.61, 1.5, 20.0])
def test_against_the_form_factor(offset: float, height: float) -> None:
    """From a tenth of a millimetre to three hundred metres, under it, under its rim, beside it."""
    x = (offset * 0.6, 2 - height, offset * 0.8)
    expected = parallel(offset, height)
    many = irradiance(x, stratified(300, np.random.default_rng(1)))
    assert many == pytest.approx(expected, rel=2e-3)
    # A soft shadow asks 64 points; over a whole hemisphere they leave a little out.
    assert irradiance(x, GRID) == pytest.approx(expected, rel=0.035 if height < 0.5 else 0.01)


def test_weights_are_even() -> None:
    """No sample weighs much more than the solid angle, and never more than a hemisphere and a bit.

    Area sampling would give 1 / height² under the lamp.
    """
    u = stratified(30, np.random.default_rng(2))
    worst = 0.0
    for offset in (0.0, 0.3, 0.55, 0.599, 0.6, 0.601, 0.7, 3.0):
        for height in (1e-6, 1e-3, 0.03, 0.3, 3.0):
            weight = illuminate(LAMP, (offset, 2 - height, 0), u)[:, 4] / 7
            worst = max(worst, weight.max() / weight.mean())
            assert weight.max() < 2.6 * math.pi
    assert worst < 2.5
    for x in ((0, -3, 0), (3, 1, 0), (9, -9, 4)):
        weight = illuminate(LAMP, x, u)[:, 4]
        assert weight.max() < 1.01 * weight.min()


def test_neighbours_stay_neighbours() -> None:
    """The middles of the cells of an 8 x 8 grid lie about as far apart on the disk."""
    u, v = np.meshgrid((np.arange(8) + 0.5) / 8, (np.arange(8) + 0.5) / 8)
    for x in ((0, 0, 0), (0.5, 1.8, 0), (2, 1, 1)):
        values = illuminate(LAMP, x, np.column_stack([u.ravel(), v.ravel()]))
        at = (np.array(x) + values[:, :3] * values[:, 3:4]).reshape(8, 8, 3)
        assert np.allclose(at[..., 1], 2)
        assert (np.hypot(at[..., 0], at[..., 2]) < 0.6).all()
        for step in (np.diff(at, axis=0), np.diff(at, axis=1)):
            assert np.linalg.norm(step, axis=2).max() < 0.42  # evenly it would be 0.15


def test_one_side_shines() -> None:
    assert illuminate(LAMP, (0, 2.5, 0), (0.4, 0.6))[0, 4] == 0
    assert emitted(LAMP, (0, 2.5, 0), (0, -1, 0))[0, 0] < 0
    assert emitted(LAMP, (0.59, 0, 0), (0, 1, 0))[0, 0] == pytest.approx(2)
    assert emitted(LAMP, (0.61, 0, 0), (0, 1, 0))[0, 0] < 0


def test_irradiance_is_continuous() -> None:
    """Along a line under the lamp and out past its rim, with the points of soft shadows."""
    found = np.array([irradiance((s, 1.9, 0), GRID) for s in np.linspace(-1.5, 1.5, 1501)])
    assert np.abs(np.diff(found)).max() < 0.02 * found.max()
    np.testing.assert_allclose(found, found[::-1], rtol=0.03)
