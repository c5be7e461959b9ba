"""Coordinates of pairs of directions: their symmetries, and the angles they stand for."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.acquisition.acquired import pairs, turned

from engine.brdf.acquisition import pairs as coordinates_of
from engine.brdf.acquisition.pairs import (
    coordinates,
    degrees_of,
    half_and_difference,
    one_of_two,
    reverse,
)
from engine.brdf.acquisition.samples import directions

both_kinds = pytest.mark.parametrize("isotropic", [True, False])


@both_kinds
def test_reverses(isotropic: bool) -> None:
    """Of a pair and its reverse, exactly."""
    wi, wo = pairs(1000)
    there, back = coordinates(wi, wo, isotropic), coordinates(wo, wi, isotropic)
    np.testing.assert_array_equal(back, reverse(there))
    np.testing.assert_array_equal(one_of_two(there), one_of_two(back))


def test_isotropic_places_do_not_turn() -> None:
    wi, wo = pairs(1000)
    place = coordinates(wi, wo, True)
    np.testing.assert_allclose(
        coordinates(turned(wi, 1.3), turned(wo, 1.3), True), place, atol=1e-9
    )
    np.testing.assert_allclose(coordinates(wi * (1, -1, 1), wo * (1, -1, 1), True), place)


def test_others_turn_with_the_pair() -> None:
    wi, wo = pairs(1000)
    place = coordinates(wi, wo, False)
    about = coordinates(turned(wi, 1.3), turned(wo, 1.3), False)
    for k in (0, 2):
        flat = np.concatenate([place[:, k : k + 2], np.zeros((1000, 1))], axis=1)
        np.testing.assert_allclose(about[:, k : k + 2], turned(flat, 1.3)[:, :2], atol=1e-9)


def test_the_pair_can_be_had_back() -> None:
    """From h and d by the textbook rotations, which `half_and_difference` does not make."""
    wi, wo = pairs(1000)
    h, e, cosine = half_and_difference(wi, wo)
    d = np.concatenate([e, cosine[:, None]], axis=1)
    np.testing.assert_allclose(np.linalg.norm(d, axis=1), 1, atol=1e-12)
    theta, phi = np.arccos(h[:, 2]), np.arctan2(h[:, 1], h[:, 0])
    d = turned(d, -phi)
    c, s = np.cos(theta), np.sin(theta)
    d = np.stack([c * d[:, 0] + s * d[:, 2], d[:, 1], c * d[:, 2] - s * d[:, 0]], axis=1)
    np.testing.assert_allclose(turned(d, phi), wi, atol=1e-9)


def test_places_are_continuous_where_the_half_vector_is_the_normal() -> None:
    wi = directions(np.full(200, 0.6), np.zeros(200))
    wo = directions(np.full(200, 0.6) + np.linspace(-1e-5, 1e-5, 200), np.full(200, np.pi))
    steps = np.abs(np.diff(coordinates(wi, wo, False), axis=0))
    assert steps[:, 2:].max() < 1e-6


@both_kinds
def test_no_place_is_undefined(isotropic: bool) -> None:
    flat, up = np.array([[1.0, 0, 0]]), np.array([[0, 0, 1.0]])
    for wi, wo in ((flat, -flat), (flat, flat), (up, up), (up, flat)):
        assert np.isfinite(coordinates(wi, wo, isotropic)).all()


def test_distances_are_angles() -> None:
    wi = directions(np.radians([50.0]), np.radians([20.0]))
    wo = directions(np.radians([[30.0], [34.0]]).ravel(), np.radians([70.0, 70.0]))
    wi = np.repeat(wi, 2, axis=0)
    for isotropic in (True, False):
        place = coordinates_of.turned(wi, wo, isotropic)
        assert degrees_of(np.linalg.norm(place[1] - place[0])) == pytest.approx(4.0)
