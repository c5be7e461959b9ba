"""Environment maps: orientation, rotation, sampling, and the light they give."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numba import njit
from scipy.stats import chi2

from engine.light import environment
from engine.light.environment import (
    Environment,
    EnvironmentDescription,
    EnvironmentTable,
    environment_table,
)
from engine.numerics.vec import vec

SAMPLES = 200_000


def _made(radiance: np.ndarray, **fields: float) -> EnvironmentTable:
    return Environment(EnvironmentDescription(**fields), np.float32(radiance)).table


def _speckled(height: int = 8, width: int = 16) -> np.ndarray:
    """Radiance over four orders of magnitude, with black pixels and a sun."""
    rng = np.random.default_rng(1)
    image = 10 ** rng.uniform(-2, 2, (height, width, 3))
    image[rng.random((height, width)) < 0.3] = 0
    image[2, width // 3] = 5000
    return image


MAPS = {
    "constant": np.ones((1, 1, 3)),
    "speckled": _speckled(),
    "black": np.zeros((4, 8, 3)),
    "one column": _speckled(16, 1),
    "one row": _speckled(4, 16)[1:2],
}
every_map = pytest.mark.parametrize("image", MAPS.values(), ids=MAPS)


@njit
def _radiance(table, d, out):
    for i in range(len(d)):
        out[i, 0], out[i, 1], out[i, 2] = environment.radiance(table, vec(d, i))


@njit
def _pdf(table, d, out):
    for i in range(len(d)):
        out[i] = environment.pdf(table, vec(d, i))


@njit
def _sample(table, u, out):
    for i in range(len(u)):
        out[i, 0], out[i, 1], out[i, 2] = environment.sample(table, u[i, 0], u[i, 1])


def radiance(table: EnvironmentTable, d: np.ndarray) -> np.ndarray:
    d = np.atleast_2d(np.asarray(d, float))
    out = np.zeros((len(d), 3))
    _radiance(table, d, out)
    return out


def pdf(table: EnvironmentTable, d: np.ndarray) -> np.ndarray:
    d = np.atleast_2d(np.asarray(d, float))
    out = np.zeros(len(d))
    _pdf(table, d, out)
    return out


def sample(table: EnvironmentTable, u: np.ndarray) -> np.ndarray:
    out = np.zeros((len(u), 3))
    _sample(table, u, out)
    return out


def _sphere(side: int) -> np.ndarray:
    """(side², 3) directions, at the middles of the pixels of a square map."""
    theta = (np.arange(side) + 0.5) * np.pi / side
    phi = (np.arange(side) + 0.5) * 2 * np.pi / side - np.pi
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    return np.stack([np.sin(t) * np.sin(p), np.cos(t), -np.sin(t) * np.cos(p)], axis=1)


def _solid_angles(side: int) -> np.ndarray:
    """(side²,) of the pixels of `_sphere`."""
    edges = np.cos(np.linspace(0, np.pi, side + 1))
    return np.repeat((edges[:-1] - edges[1:]) * 2 * np.pi / side, side)


def _numbers() -> np.ndarray:
    return np.random.default_rng(2).random((SAMPLES, 2))


@every_map
def test_density_integrates_to_one(image: np.ndarray) -> None:
    density = pdf(_made(image, rotation_degrees=33), _sphere(1200))
    assert (density > 0).all()
    assert (density * _solid_angles(1200)).sum() == pytest.approx(1, rel=1e-6)


@every_map
def test_chi_square(image: np.ndarray) -> None:
    """Samples fall into each pixel, and into each quarter of it, as often as the density says."""
    table = _made(image, rotation_degrees=33)
    height, width = 2 * image.shape[0], 2 * image.shape[1]
    d = sample(table, _numbers())
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=1e-12)
    # Turn back by hand what the map's rotation turned.
    angle = math.radians(33)
    x = math.cos(angle) * d[:, 0] - math.sin(angle) * d[:, 2]
    z = math.sin(angle) * d[:, 0] + math.cos(angle) * d[:, 2]
    row = np.minimum((np.arccos(d[:, 1]) / np.pi * height).astype(int), height - 1)
    column = ((0.5 + np.arctan2(x, -z) / (2 * np.pi)) * width).astype(int) % width
    observed = np.bincount(row * width + column, minlength=height * width)
    theta = (np.arange(height) + 0.5) * np.pi / height
    phi = (np.arange(width) + 0.5) * 2 * np.pi / width - np.pi + 1e-9
    t, p = (a.ravel() for a in np.meshgrid(theta, phi, indexing="ij"))
    centre = np.stack([np.sin(t) * np.sin(p), np.cos(t), -np.sin(t) * np.cos(p)], axis=1)
    turned = centre.copy()
    turned[:, 0] = math.cos(angle) * centre[:, 0] + math.sin(angle) * centre[:, 2]
    turned[:, 2] = -math.sin(angle) * centre[:, 0] + math.cos(angle) * centre[:, 2]
    edges = np.cos(np.linspace(0, np.pi, height + 1))
    solid = np.repeat((edges[:-1] - edges[1:]) * 2 * np.pi / width, width)
    expected = pdf(table, turned) * solid * SAMPLES
    order = np.argsort(expected)
    e, o = expected[order], observed[order].astype(float)
    few = np.searchsorted(np.cumsum(e), 5.0) + 1
    e, o = np.append(e[:few].sum(), e[few:]), np.append(o[:few].sum(), o[few:])
    assert e.sum() == pytest.approx(SAMPLES, rel=1e-6)
    statistic = ((o - e) ** 2 / e).sum()
    # Šidák, as for the BRDFs: one false alarm in a hundred for all maps together.
    assert chi2.sf(statistic, len(e) - 1) > 1 - 0.99 ** (1 / len(MAPS))


@every_map
def test_samples_have_their_pixel_s_density(image: np.ndarray) -> None:
    """radiance / pdf is nearly constant: what importance sampling is for."""
    table = _made(image)
    d = sample(table, _numbers()[:20000])
    total = _solid_angles(480) @ radiance(table, _sphere(480))
    estimate = (radiance(table, d) / pdf(table, d)[:, None]).mean(axis=0)
    np.testing.assert_allclose(estimate, total, rtol=0.03, atol=1e-9)


def test_even_map_is_sampled_evenly() -> None:
    """Pixels that shrink towards the poles are taken as much less often."""
    density = pdf(_made(np.full((16, 32, 3), 0.3)), _sphere(100))
    np.testing.assert_allclose(density, 1 / (4 * np.pi), rtol=1e-4)


def test_constant_map_gives_pi_times_its_radiance() -> None:
    """Irradiance of an open surface under radiance L is π L."""
    table = _made(np.full((1, 1, 3), 0.4), intensity=2.5)
    normal = np.array([0.6, 0.0, 0.8])
    d = sample(table, _numbers())
    weight = np.maximum(d @ normal, 0) / pdf(table, d)
    irradiance = (radiance(table, d) * weight[:, None]).mean(axis=0)
    np.testing.assert_allclose(irradiance, np.pi, rtol=0.01)


@pytest.mark.parametrize(
    ("row", "column", "d"),
    [
        (0, 3, (1e-6, 1, 0)),  # top row looks up
        (7, 3, (1e-6, -1, 0)),
        (4, 8, (0.05, -0.05, -1)),  # middle column looks along -z
        (4, 0, (-0.05, -0.05, 1)),  # its ends along +z
        (4, 12, (1, -0.05, 0.05)),  # to its right, +x
        (4, 4, (-1, -0.05, -0.05)),
    ],
)
def test_orientation(row: int, column: int, d: tuple[float, float, float]) -> None:
    image = np.zeros((8, 16, 3))
    image[row, column if 0 < row < 7 else slice(None)] = (1, 2, 3)
    unit = np.asarray(d) / np.linalg.norm(d)
    np.testing.assert_allclose(radiance(_made(image), unit), [(1, 2, 3)])
    lit = radiance(_made(image), _sphere(200)).any(axis=1) @ _solid_angles(200)
    assert lit < 0.06 * 4 * np.pi


def test_rotation_is_counter_clockwise_from_above() -> None:
    """By 90 degrees, what stood at -z stands at -x, and what stood at +x at -z."""
    image = np.zeros((9, 16, 3))
    image[4, 7:9] = 1
    for degrees, d in ((0, (0, 0, -1)), (90, (-1, 0, 0)), (180, (0, 0, 1)), (-90, (1, 0, 0))):
        table = _made(image, rotation_degrees=degrees)
        assert (radiance(table, np.add(d, 1e-3 * np.array([1, 0, 1]))) == 1).all()
        assert radiance(table, _sphere(300)).any(axis=1).mean() < 0.04


@pytest.mark.parametrize("rotation", [0.0, 33.0, -200.0])
def test_one_bright_pixel_comes_back(rotation: float) -> None:
    """Almost every sample goes to the one bright pixel and finds its radiance there."""
    image = np.zeros((32, 64, 3))
    image[9, 40] = (10, 20, 30)
    table = _made(image, rotation_degrees=rotation, intensity=2)
    d = sample(table, _numbers()[:10000])
    seen = radiance(table, d)
    bright = seen[:, 0] > 0
    assert bright.mean() > 0.999
    np.testing.assert_allclose(seen[bright], np.tile([20, 40, 60], (bright.sum(), 1)))
    # A direction near the pixel's middle, turned by hand.
    theta, phi = (9 + 0.5) * np.pi / 32, (40 + 0.5) * 2 * np.pi / 64 - np.pi
    middle = np.array([np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)])
    a = math.radians(rotation)
    turn = np.array([[math.cos(a), 0, math.sin(a)], [0, 1, 0], [-math.sin(a), 0, math.cos(a)]])
    mean = d[bright].mean(axis=0)
    np.testing.assert_allclose(mean / np.linalg.norm(mean), turn @ middle, atol=2e-3)


def test_no_environment_is_black() -> None:
    table = environment_table(None)
    d = _sphere(10)
    assert (radiance(table, d) == 0).all()
    assert (pdf(table, d) == 0).all()


@every_map
def test_finite_at_the_seams(image: np.ndarray) -> None:
    """Poles, seam and the ends of the random numbers give finite values."""
    table = _made(image, rotation_degrees=90)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    d = np.concatenate([axes, axes + 1e-17, axes * (1 + 1e-7)])
    ends = np.array([0.0, 1 - 2.0**-24, 1 - 2.0**-53])
    u = np.stack(np.meshgrid(ends, ends), axis=-1).reshape(-1, 2)
    d = np.concatenate([d, sample(table, u)])
    assert np.isfinite(d).all()
    assert np.isfinite(radiance(table, d)).all()
    assert np.isfinite(pdf(table, d)).all()
    assert (pdf(table, d) > 0).all()
