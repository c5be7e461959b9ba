"""Environment samples: means of the map over equal cells, however it is turned; look-ups exact."""

from __future__ import annotations

import numpy as np
import pytest
from numba import njit

from engine.light import environment
from engine.light.environment import Environment, EnvironmentDescription
from engine.light.environment_samples import (
    DEPTH,
    averaged,
    environment_samples,
    places_on_map,
    seen_radiance,
)
from engine.light.maps import studio
from engine.numerics.octahedron import centres
from engine.numerics.vec import vec


def made(image: np.ndarray, **fields: float) -> Environment:
    return Environment(EnvironmentDescription(**fields), np.ascontiguousarray(image, np.float32))


def flux(image: np.ndarray) -> np.ndarray:
    """(3,) integral of a map (h, w, 3) over the sphere."""
    edges = np.cos(np.linspace(0, np.pi, len(image) + 1))
    solid = (edges[:-1] - edges[1:]) * 2 * np.pi / image.shape[1]
    return (image * solid[:, None, None]).sum(axis=(0, 1), dtype=np.float64)


def noise(height: int, width: int) -> np.ndarray:
    return np.random.default_rng(3).uniform(0, 1, (height, width, 3)).astype(np.float32)


@njit
def _radiance(table, d, out):
    for i in range(len(d)):
        out[i, 0], out[i, 1], out[i, 2] = environment.radiance(table, vec(d, i))


@pytest.mark.parametrize("turn", [0.0, 33.0, -200.0])
def test_what_is_seen_is_what_every_renderer_sees(turn: float) -> None:
    where = made(noise(37, 74), rotation_degrees=turn, intensity=2.5)
    d = np.random.default_rng(4).normal(size=(5000, 3))
    d /= np.linalg.norm(d, axis=1, keepdims=True)
    expected = np.zeros((len(d), 3))
    _radiance(where.table, d, expected)
    found = seen_radiance(where, places_on_map(d))
    # A place within rounding of a border may fall to either side of it.
    assert np.isclose(found, expected, rtol=1e-6).all(axis=1).mean() > 0.999


@pytest.mark.parametrize("size", [(1, 1), (4, 16), (128, 256), (700, 1400), (1025, 2050)])
@pytest.mark.parametrize("turn", [0.0, 11.3, 270.0])
def test_no_light_is_lost(size: tuple[int, int], turn: float) -> None:
    image = noise(*size)
    samples = environment_samples(made(image, rotation_degrees=turn, intensity=3))
    assert samples.shape == (4**DEPTH, 3)
    found = samples.mean(axis=0, dtype=np.float64) * 4 * np.pi
    np.testing.assert_allclose(found, 3 * flux(image), rtol=2e-3)


def test_a_small_sun_keeps_its_light_while_it_turns() -> None:
    """One pixel of 0.7 degrees, between places 0.4 degrees apart."""
    image = np.zeros((256, 512, 3), np.float32)
    image[90, 200] = 1000
    found = [
        environment_samples(made(image, rotation_degrees=k * 0.37)).mean(dtype=np.float64)
        for k in range(12)
    ]
    np.testing.assert_allclose(np.array(found) * 4 * np.pi, flux(image).mean(), rtol=0.06)


def test_even_light_is_even() -> None:
    samples = environment_samples(made(np.full((1, 1, 3), 0.7), rotation_degrees=20))
    np.testing.assert_allclose(samples, 0.7, rtol=1e-6)


def test_samples_are_means_of_their_cells() -> None:
    """Against many places in each of a few cells."""
    where = made(studio(), rotation_degrees=25)
    samples = environment_samples(where)
    fine = seen_radiance(where, places_on_map(centres(DEPTH + 3)))
    expected = fine.reshape(4**DEPTH, 64, 3).mean(axis=1)
    assert np.abs(samples - expected).max() < 0.03 * expected.max()
    assert np.abs(samples - expected).mean() < 0.003 * expected.mean()


@pytest.mark.parametrize("size", [(700, 1400), (1025, 2050), (2048, 4096)])
def test_a_large_map_is_averaged_without_loss(size: tuple[int, int]) -> None:
    image = noise(*size)
    small = averaged(image)
    assert small.shape[1] <= 1024
    # Blocks at the end of a map that no whole number of them fills are smaller.
    np.testing.assert_allclose(small.mean(), image.mean(), rtol=3e-3)
    assert averaged(small) is small
