"""Scattered samples made into functions: laws, recovery of models, and what could break them."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from brdf.acquisition.acquired import completed, pairs, relative, sampled, turned
from numpy.typing import NDArray

from engine.brdf.acquisition import goniometer, of_material
from engine.brdf.acquisition.completion import complete
from engine.brdf.acquisition.reciprocity import balanced
from engine.brdf.acquisition.samples import Samples, directions
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.numerics import parallel

GLOSS = Ggx(roughness=0.4, diffuse=(0.3, 0.1, 0.02))
BRUSHED = AshikhminShirley(exponent_u=10, exponent_v=80)
isotropic_or_not = pytest.mark.parametrize("isotropic", [True, False])


def few(n: int, *, rgb: NDArray | None = None) -> Samples:
    """n samples that stay away from grazing angles."""
    rng = np.random.default_rng(3)
    wi, wo = (directions(1.2 * rng.random(n), 6 * rng.random(n)) for _ in range(2))
    return Samples("few", wi, wo, np.full((n, 3), 0.25) if rgb is None else rgb)


def is_sane(samples: Samples, isotropic: bool, limit: float = 1.0) -> NDArray[np.float64]:
    """Values (q, 3) everywhere, which are finite and within `limit` times the samples."""
    wi, wo = pairs(3000)
    grazing = directions(np.full(50, np.pi / 2), np.linspace(0, 6, 50))
    wi = np.concatenate([wi, grazing, grazing, wi[:50], [[0, 0, 1.0]], [[1.0, 0, 0]]])
    wo = np.concatenate([wo, grazing, -grazing * (1, 1, -1), grazing, [[0, 0, 1.0]], [[1.0, 0, 0]]])
    value = complete(samples, isotropic).evaluate(wi, wo)
    assert np.isfinite(value).all()
    assert (value >= 0).all()
    assert (value <= limit * samples.rgb.max(axis=0) * (1 + 1e-9)).all()
    return value


@isotropic_or_not
def test_reciprocal_to_the_last_bit(isotropic: bool) -> None:
    """Though the samples are not: their values are random."""
    samples = replace(few(500), rgb=np.random.default_rng(1).random((500, 3)))
    function = complete(samples, isotropic)
    wi, wo = pairs(5000)
    np.testing.assert_array_equal(function.evaluate(wi, wo), function.evaluate(wo, wi))


def test_isotropic_data_stay_isotropic() -> None:
    function = completed(sampled(GLOSS, *pairs(1500)))
    assert function.isotropic
    wi, wo = pairs(2000, seed=5)
    value = function.evaluate(wi, wo)
    for angle in (0.3, 2.0, 4.5):
        about = function.evaluate(turned(wi, angle), turned(wo, angle))
        np.testing.assert_allclose(about, value, rtol=1e-7, atol=1e-12)
    mirrored = function.evaluate(wi * (1, -1, 1), wo * (1, -1, 1))
    np.testing.assert_allclose(mirrored, value, rtol=1e-7, atol=1e-12)


@isotropic_or_not
def test_a_diffuse_measurement_gives_back_a_constant(isotropic: bool) -> None:
    samples = sampled(Diffuse(diffuse=(0.9, 0.3, 0.01)), *pairs(300))
    wi, wo = pairs(2000, seed=2)
    value = complete(samples, isotropic).evaluate(wi, wo)
    np.testing.assert_allclose(value, np.tile(samples.rgb[0], (2000, 1)), rtol=1e-9)


@pytest.mark.parametrize(
    ("material", "counts", "errors"),
    [(GLOSS, (1000, 4000, 16000), (0.05, 0.02, 0.01)), (BRUSHED, (2000, 30000), (0.2, 0.08))],
    ids=["isotropic", "anisotropic"],
)
def test_a_model_is_recovered(
    material: Ggx | AshikhminShirley, counts: tuple[int, ...], errors: tuple[float, ...]
) -> None:
    """Up to a median relative error that shrinks with the number of samples."""
    wi, wo = pairs(3000, seed=11)
    true = of_material(material).evaluate(wi, wo)
    found = []
    for count, bound in zip(counts, errors, strict=True):
        function = completed(sampled(material, *pairs(count)))
        assert function.isotropic == (material is GLOSS)
        found.append(float(np.median(relative(function.evaluate(wi, wo), true))))
        assert found[-1] < bound
    assert found == sorted(found, reverse=True)


def test_noise_is_smoothed() -> None:
    """Under noise of 20 % the function is nearer to the model than the samples are."""
    wi, wo = pairs(4000)
    function = complete(sampled(GLOSS, wi, wo, noise=0.2), True)
    true = of_material(GLOSS).evaluate(wi, wo)
    assert np.mean(relative(function.evaluate(wi, wo), true)) < 0.11
    assert np.mean(relative(function.samples.rgb, true)) > 0.15


@pytest.mark.parametrize("count", [3, 5, 30, 400])
def test_nothing_steps(count: int) -> None:
    """Along a curve of directions a change is as small as the way, though samples are random."""
    samples = few(count, rgb=0.1 + np.random.default_rng(1).random((count, 3)))
    for isotropic in (True, False):
        function = complete(samples, isotropic)
        changes = []
        for n in (2000, 8000):
            theta = np.linspace(0, 1.5, n)
            wo = directions(theta, 3 * theta)
            wi = np.tile(directions(np.array([0.7]), np.array([0.2])), (n, 1))
            changes.append(np.abs(np.diff(function.evaluate(wi, wo), axis=0)).max())
        assert changes[1] < 0.35 * changes[0]


@isotropic_or_not
@pytest.mark.parametrize("n", [1, 2, 3, 5])
def test_few_samples(n: int, isotropic: bool) -> None:
    value = is_sane(few(n, rgb=np.random.default_rng(1).random((n, 3))), isotropic)
    if n == 1:
        np.testing.assert_allclose(value, np.broadcast_to(value[0], value.shape), rtol=1e-9)


@isotropic_or_not
def test_many_samples_of_one_pair(isotropic: bool) -> None:
    """As an instrument that repeats itself makes them; the value is their middle."""
    one = few(1)
    rgb = np.random.default_rng(1).uniform(0.2, 0.3, (40, 3))
    value = is_sane(
        Samples("one", np.tile(one.wi, (40, 1)), np.tile(one.wo, (40, 1)), rgb), isotropic
    )
    np.testing.assert_allclose(value, np.tile(rgb.mean(axis=0), (len(value), 1)), rtol=0.02)


@isotropic_or_not
def test_at_a_sample_that_is_its_own_reverse(isotropic: bool) -> None:
    """Both stand at the same place, and so does the query."""
    up = np.array([[0, 0, 1.0]])
    function = complete(Samples("up", up, up, np.full((1, 3), 0.25)), isotropic)
    np.testing.assert_allclose(function.evaluate(up, up), 0.25, rtol=1e-9)


@isotropic_or_not
def test_a_black_channel_stays_black(isotropic: bool) -> None:
    rgb = np.random.default_rng(1).random((300, 3)) * (1, 0, 1)
    value = is_sane(few(300, rgb=rgb), isotropic)
    assert (value[:, 1] < 1e-12).all()
    assert (value[:, 0] > 0).all()


@isotropic_or_not
def test_all_black(isotropic: bool) -> None:
    assert (is_sane(few(50, rgb=np.zeros((50, 3))), isotropic, limit=0.0) == 0).all()


@isotropic_or_not
def test_five_orders_of_magnitude(isotropic: bool) -> None:
    """Neither the lobe of 10⁵ nor the rest runs away."""
    samples = few(2000)
    cosine = np.einsum("ij,ij->i", samples.wi * (-1, -1, 1), samples.wo)
    rgb = np.repeat((1e-3 + 1e2 * np.exp((cosine - 1) / 0.01))[:, None], 3, axis=1)
    is_sane(replace(samples, rgb=rgb), isotropic)


@isotropic_or_not
def test_samples_on_the_horizon(isotropic: bool) -> None:
    """Opposite ones have no half vector."""
    phi = np.linspace(0, 2 * np.pi, 40)
    wi, wo = (
        directions(np.full(40, np.pi / 2), phi),
        directions(np.full(40, np.pi / 2), phi + np.pi),
    )
    is_sane(Samples("horizon", wi, wo, np.random.default_rng(1).random((40, 3))), isotropic)


@isotropic_or_not
def test_outside_the_data_values_are_those_of_the_edge(isotropic: bool) -> None:
    """A lobe that rises towards the horizon must not be carried on beyond the last samples."""
    samples = few(1000)
    rising = np.exp(4 * (1 - samples.wi[:, 2]) + 4 * (1 - samples.wo[:, 2]))
    is_sane(replace(samples, rgb=np.repeat(rising[:, None], 3, axis=1)), isotropic)


def test_one_plane_is_enough() -> None:
    """In-plane scans alone are completed as isotropic ones, and hold where they were measured."""
    theta_i, theta_o = (x.ravel() for x in np.meshgrid(np.arange(5, 76, 5), np.arange(-75, 76, 5)))
    wi = directions(np.radians(theta_i), np.zeros(theta_i.size))
    wo = directions(np.radians(theta_o), np.zeros(theta_o.size))
    function = completed(sampled(GLOSS, wi, wo))
    assert function.isotropic
    assert np.median(relative(function.evaluate(wi, wo), function.samples.rgb)) < 0.05
    is_sane(function.samples, True)


def test_below_the_surface_is_black() -> None:
    function = complete(few(20), True)
    up, down = np.array([[0.6, 0, 0.8]]), np.array([[0.6, 0, -0.8]])
    assert (function.evaluate(up, up) > 0).all()
    for a, b in ((up, down), (down, up), (down, down)):
        assert (function.evaluate(a, b) == 0).all()
    assert function.evaluate(np.zeros((0, 3)), np.zeros((0, 3))).shape == (0, 3)


@isotropic_or_not
def test_the_same_in_any_order_and_number(isotropic: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    function = complete(sampled(BRUSHED, *pairs(1500)), isotropic)
    wi, wo = pairs(2000, seed=3)
    whole = function.evaluate(wi, wo)
    np.testing.assert_array_equal(function.evaluate(wi[::-1], wo[::-1])[::-1], whole)
    np.testing.assert_array_equal(function.evaluate(wi[5:9], wo[5:9]), whole[5:9])
    monkeypatch.setattr(parallel, "thread_count", lambda: 1)
    np.testing.assert_array_equal(function.evaluate(wi, wo), whole)


def test_samples_and_reverses_meet_halfway() -> None:
    """Where steep light reads 30 % too bright, what is left of it is the same on both sides."""
    wi, wo = pairs(4000)
    true = of_material(GLOSS).evaluate(wi, wo)
    wrong = np.where(wi[:, 2:] > wo[:, 2:], 1.3, 1 / 1.3)
    apart = np.abs(wi[:, 2] - wo[:, 2]) > 0.2
    value = complete(Samples("wrong", wi, wo, true * wrong), True).evaluate(wi, wo)
    assert np.median(relative(value, true)[apart]) < 0.06


def test_reverses_that_were_not_measured_move_nothing() -> None:
    places = np.random.default_rng(1).uniform((0, 0, 1), (1, 1, 2), (200, 3))
    logs = np.random.default_rng(2).random((200, 3))
    np.testing.assert_array_equal(balanced(places, logs), logs)


@pytest.mark.data
@pytest.mark.parametrize(
    ("name", "error"), [("garnet_red", 0.04), ("krylon_blue", 0.06), ("mystique", 0.3)]
)
def test_real_samples_are_foretold(shared_data: Path, name: str, error: float) -> None:
    """A tenth of them from the others: the median relative error of the luminance."""
    samples = goniometer.read(shared_data / "brdfs" / f"{name}.brdf")
    out = np.random.default_rng(0).permutation(len(samples.rgb))[::10]
    rest = np.setdiff1d(np.arange(len(samples.rgb)), out)
    some = replace(samples, wi=samples.wi[rest], wo=samples.wo[rest], rgb=samples.rgb[rest])
    grey = np.array([0.2126, 0.7152, 0.0722])
    true = samples.rgb[out] @ grey
    told = complete(some, True).evaluate(samples.wi[out], samples.wo[out]) @ grey
    assert np.median(np.abs(told - true) / true) < error
    is_sane(samples, True)
