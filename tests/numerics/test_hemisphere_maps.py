"""Maps over the hemisphere: what a texel holds comes back, and nothing jumps."""

from __future__ import annotations

import numpy as np
import pytest

from engine.numerics.hemisphere_maps import Texels, look_up, texels


def filled(grid: Texels, values: np.ndarray) -> np.ndarray:
    """A map (n, n, c) with values (m, c) at its texels."""
    flat = np.full((grid.size**2, values.shape[1]), np.nan, np.float32)
    flat[grid.number] = values
    return flat.reshape(grid.size, grid.size, -1)


def local(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


@pytest.mark.parametrize("polar", [False, True])
@pytest.mark.parametrize("size", [2, 16, 48])
def test_texels_come_back(size: int, polar: bool) -> None:
    grid = texels(size, polar=polar)
    np.testing.assert_allclose(np.linalg.norm(grid.direction, axis=1), 1)
    inner = len(grid.weight)
    values = np.random.default_rng(1).random((len(grid.number), 2))
    found = look_up(filled(grid, values), grid.direction[:inner], polar=polar)
    np.testing.assert_allclose(found, values[:inner], atol=1e-5)


@pytest.mark.parametrize("polar", [False, True])
def test_every_direction_finds_texels(polar: bool) -> None:
    """No look-up of the hemisphere, its rim included, meets a texel that nobody fills."""
    grid = texels(16, polar=polar)
    rng = np.random.default_rng(2)
    theta = np.append(np.arccos(rng.random(20000)), np.full(1000, np.pi / 2 - 1e-9))
    w = local(theta, 2 * np.pi * rng.random(21000))
    found = look_up(filled(grid, np.ones((len(grid.number), 1))), w, polar=polar)
    np.testing.assert_allclose(found, 1, atol=1e-6)


def test_weights_are_projected_solid_angles() -> None:
    """A mean of cos θ over the cosine-weighted hemisphere is 2/3."""
    for polar in (False, True):
        grid = texels(96, polar=polar)
        z = grid.direction[: len(grid.weight), 2]
        # The disk's grid leaves its rim to the guards, a hundredth of its area.
        assert np.average(z, weights=grid.weight) == pytest.approx(
            2 / 3, abs=1e-3 if polar else 6e-3
        )
    # The paper's matrix has 37.5 MB of float32 for three channels of 48 x 48 texels: ours all but
    # those at the rim.
    assert 3 * 4 * len(texels(48).weight) ** 2 / 2**20 == pytest.approx(37.5, rel=0.06)
    assert texels(48).direction[: len(texels(48).weight), 2].min() > 0.14


@pytest.mark.parametrize("theta", [0.02, 0.5, 1.2])
def test_the_polar_map_has_no_seam(theta: float) -> None:
    """Over the edge of the texture the values go on; the paper's implementation could not, §6."""
    grid = texels(32, polar=True)
    maps = filled(grid, np.random.default_rng(3).random((len(grid.number), 1)))
    # The edge is where atan2(w_x, w_y) jumps from π to -π: at w_x = 0, w_y < 0.
    phi = -np.pi / 2 + np.array([-1e-6, 1e-6])
    left, right = look_up(maps, local(np.full(2, theta), phi), polar=True)[:, 0]
    assert left == pytest.approx(right, abs=1e-4)
    # And all round no step is larger than a texel's worth.
    phi = np.linspace(0, 2 * np.pi, 20001)
    around = look_up(maps, local(np.full(20001, theta), phi), polar=True)[:, 0]
    assert np.abs(np.diff(around)).max() < 2 * 32 / 20000


def test_the_polar_map_is_smooth_at_its_pole() -> None:
    """All columns end in one direction: what is smooth there comes back so, along any way."""
    grid = texels(32, polar=True)

    def smooth(w: np.ndarray) -> np.ndarray:
        return 0.3 + w[:, :1] - 0.5 * w[:, 1:2] + 2 * w[:, :1] * w[:, 1:2]

    maps = filled(grid, smooth(grid.direction))
    x = np.linspace(-0.05, 0.05, 2001)
    for phi in np.linspace(0, np.pi, 7):
        w = np.stack([x * np.cos(phi), x * np.sin(phi), np.sqrt(1 - x * x)], axis=1)
        np.testing.assert_allclose(look_up(maps, w, polar=True), smooth(w), atol=2e-3)


def test_an_odd_polar_map_is_refused() -> None:
    with pytest.raises(ValueError, match="even size, not 33"):
        texels(33, polar=True)
