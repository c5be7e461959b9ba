"""An environment as a cube map: constants, energy at any angle, no flicker, no seam."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from numpy.typing import NDArray

from engine.light.cube_light import CubeLight, in_haar, resampled
from engine.light.environment import Environment, EnvironmentDescription
from engine.numerics.cube_map import directions, solid_angles

N = 16


def made(image: NDArray, **fields: float) -> Environment:
    return Environment(EnvironmentDescription(**fields), np.ascontiguousarray(image, np.float32))


def noise(height: int, width: int) -> NDArray[np.float32]:
    return np.random.default_rng(3).uniform(0, 1, (height, width, 3)).astype(np.float32)


def flux(image: NDArray) -> NDArray[np.float64]:
    edges = np.cos(np.linspace(0, np.pi, len(image) + 1))
    solid = (edges[:-1] - edges[1:]) * 2 * np.pi / image.shape[1]
    return (image * solid[:, None, None]).sum(axis=(0, 1), dtype=np.float64)


def sun(row: int, column: int, size: tuple[int, int] = (128, 256)) -> NDArray[np.float32]:
    image = np.zeros((*size, 3), np.float32)
    image[row, column] = 1e6
    return image


@pytest.fixture(scope="module")
def light() -> CubeLight:
    return CubeLight(N)


def test_without_an_environment_it_is_black(light: CubeLight) -> None:
    assert not light.radiance(None).any()


@pytest.mark.parametrize("turn", [0.0, 17.3, -90.0])
def test_a_constant_stays_constant(light: CubeLight, turn: float) -> None:
    image = np.full((5, 10, 3), [0.5, 1, 2], np.float32)
    found = light.radiance(made(image, rotation_degrees=turn, intensity=3))
    assert np.allclose(found, [1.5, 3, 6], rtol=1e-4)


@pytest.mark.parametrize("size", [(1, 2), (37, 74), (64, 128), (300, 600)])
@pytest.mark.parametrize("turn", [0.0, 0.1, 45.0, 123.4, 359.9])
def test_energy_is_kept_at_any_angle(light: CubeLight, size: tuple[int, int], turn: float) -> None:
    image = noise(*size)
    found = light.radiance(made(image, rotation_degrees=turn))
    total = (found * solid_angles(N)[:, None]).sum(axis=0)
    assert np.allclose(total, flux(image), rtol=1e-3)


@pytest.mark.parametrize("row", [0, 20, 63, 64, 100, 127])
def test_a_single_bright_pixel_keeps_its_energy_and_its_place(light: CubeLight, row: int) -> None:
    image = sun(row, 77)
    for turn in np.linspace(0, 10, 7):
        found = light.radiance(made(image, rotation_degrees=turn))[:, 0] * solid_angles(N)
        assert found.sum() == pytest.approx(flux(image)[0], rel=1e-3)
        theta, phi = np.pi * (row + 0.5) / 128, 2 * np.pi * (77.5 / 256 - 0.5) - np.radians(turn)
        d = [np.sin(theta) * np.sin(phi), np.cos(theta), -np.sin(theta) * np.cos(phi)]
        middle = found @ directions(N)
        assert middle @ d / np.linalg.norm(middle) > np.cos(np.radians(90 / N))


def test_a_small_turn_makes_a_small_change(light: CubeLight) -> None:
    """A sun that moves by a hundredth of a texel never moves more than that of its light."""
    step = 0.01 * 90 / N
    frames = [
        light.radiance(made(sun(60, 5), rotation_degrees=k * step))[:, 0] * solid_angles(N)
        for k in range(60)
    ]
    total = frames[0].sum()
    changes = [np.abs(b - a).sum() / 2 / total for a, b in pairwise(frames)]
    assert max(changes) < 0.1


def test_the_seam_of_the_map_is_nowhere(light: CubeLight) -> None:
    image = noise(32, 64)
    rolled = np.roll(image, 24, axis=1)
    a = light.radiance(made(image, rotation_degrees=10.0))
    b = light.radiance(made(rolled, rotation_degrees=10.0 + 24 / 64 * 360))
    assert np.allclose(a, b, atol=1e-3)


def test_the_map_is_read_as_every_renderer_reads_it(light: CubeLight) -> None:
    """Bright towards -x alone: the middle of the left half of the map."""
    image = np.zeros((64, 128, 3), np.float32)
    image[:, 16:48] = 1
    found = light.radiance(made(image))[:, 0]
    assert (found[directions(N)[:, 0] < -0.8] > 0.99).all()
    assert (found[directions(N)[:, 0] > 0.1] == 0).all()


@pytest.mark.parametrize("size", [(7, 14), (64, 128), (200, 400)])
def test_resampling_keeps_the_flux(size: tuple[int, int]) -> None:
    image = noise(*size)
    assert np.allclose(flux(resampled(image, 64, 128)), flux(image), rtol=1e-5)


def test_resampling_to_the_same_size_changes_nothing() -> None:
    image = noise(64, 128)
    assert np.allclose(resampled(image, 64, 128), image, rtol=1e-5)


def test_the_basis_is_orthonormal() -> None:
    a, b = np.random.default_rng(2).normal(size=(2, 6 * N * N, 3)).astype(np.float32)
    assert np.allclose((in_haar(a) * in_haar(b)).sum(), (a * b).sum(), rtol=1e-3)
