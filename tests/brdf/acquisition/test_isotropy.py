"""Which samples are taken as those of an isotropic material."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from brdf.acquisition.acquired import pairs, sampled, turned

from engine.brdf.acquisition import goniometer
from engine.brdf.acquisition.isotropy import is_isotropic
from engine.brdf.acquisition.samples import Samples, directions
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.ggx import Ggx

BRUSHED = AshikhminShirley(exponent_u=10, exponent_v=80)


@pytest.mark.parametrize("noise", [0.0, 0.1, 0.3])
@pytest.mark.parametrize("n", [200, 2000])
def test_isotropic_models_are_isotropic(n: int, noise: float) -> None:
    assert is_isotropic(sampled(Ggx(roughness=0.3), *pairs(n), noise=noise))


@pytest.mark.parametrize("noise", [0.0, 0.1])
def test_a_grain_is_seen(noise: float) -> None:
    samples = sampled(BRUSHED, *pairs(2000), noise=noise)
    assert not is_isotropic(samples)
    quarter = replace(samples, wi=turned(samples.wi, 0.7), wo=turned(samples.wo, 0.7))
    assert not is_isotropic(quarter)


def test_a_nap_is_seen() -> None:
    """Brighter from one side than from the other, as velvet that was stroked."""
    wi, wo = pairs(2000)
    side = 1 + 0.5 * (wi + wo)[:, :1] / np.linalg.norm(wi + wo, axis=1, keepdims=True)
    assert not is_isotropic(Samples("nap", wi, wo, 0.1 * np.repeat(side, 3, axis=1)))


@pytest.mark.parametrize("step", [30, 90])
def test_regular_grids(step: int) -> None:
    angles = [np.arange(0, 81, 20), np.arange(0, 360, step)] * 2
    theta_i, phi_i, theta_o, phi_o = (x.ravel() for x in np.radians(np.meshgrid(*angles)))
    wi, wo = directions(theta_i, phi_i), directions(theta_o, phi_o)
    assert is_isotropic(sampled(Ggx(roughness=0.3), wi, wo))
    assert not is_isotropic(sampled(BRUSHED, wi, wo))


def test_what_cannot_tell_is_isotropic() -> None:
    """Light from one azimuth or from the normal, few samples, black ones."""
    wi, wo = pairs(500)
    theta = np.arccos(wi[:, 2])
    assert is_isotropic(sampled(BRUSHED, directions(theta, np.full(500, 0.4)), wo))
    assert is_isotropic(sampled(BRUSHED, np.tile([[0, 0, 1.0]], (500, 1)), wo))
    assert is_isotropic(sampled(BRUSHED, wi[:20], wo[:20]))
    assert is_isotropic(Samples("black", wi, wo, np.zeros((500, 3))))


@pytest.mark.data
@pytest.mark.parametrize("name", ["garnet_red", "krylon_blue", "mystique"])
def test_real_paints_turned_at_random(shared_data: Path, name: str) -> None:
    samples = goniometer.read(shared_data / "brdfs" / f"{name}.brdf")
    angle = 2 * np.pi * np.random.default_rng(1).random(len(samples.rgb))
    about = replace(samples, wi=turned(samples.wi, angle), wo=turned(samples.wo, angle))
    assert is_isotropic(about)
