"""The display transform against the standard and another library."""

from __future__ import annotations

import colour
import numpy as np
import pytest

from engine.numerics.display import linear_from_srgb, srgb_from_linear, to_srgb, to_srgb8


def test_curve_against_another_library() -> None:
    x = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(srgb_from_linear(x), colour.models.eotf_inverse_sRGB(x), atol=1e-7)
    np.testing.assert_allclose(linear_from_srgb(x), colour.models.eotf_sRGB(x), atol=1e-7)
    # The standard's two branches meet to within its own rounding.
    np.testing.assert_allclose(linear_from_srgb(srgb_from_linear(x)), x, atol=1e-6)


def test_every_byte_comes_back() -> None:
    """A picture that was read from bytes is shown as the same bytes."""
    every = np.arange(256)
    linear = linear_from_srgb(every / 255).astype(np.float32)
    np.testing.assert_array_equal(to_srgb8(linear), every)


def test_fast_bytes_equal_the_curve() -> None:
    """Where the curve is not within a twentieth of half-way between two bytes, exactly."""
    x = np.concatenate([np.linspace(-0.1, 1.1, 100_001), np.geomspace(1e-7, 1, 100_000)])
    for exposure in (-2.5, 0.0, 3.0):
        image = np.float32(x / 2**exposure)
        exact = 255 * to_srgb(image, exposure)
        fast = to_srgb8(image, exposure).astype(float)
        assert np.abs(fast - exact).max() < 0.55
        clear = np.abs(exact % 1 - 0.5) > 0.05
        np.testing.assert_array_equal(fast[clear], np.round(exact[clear]))


def test_exposure_is_in_stops() -> None:
    assert to_srgb8(np.float32([0.25]), 2.0)[0] == 255
    np.testing.assert_allclose(
        to_srgb(np.float32([0.1, 0.2]), 1.0), srgb_from_linear([0.2, 0.4]), atol=1e-6
    )


@pytest.mark.parametrize("shape", [(5, 3), (4, 6, 3), (0, 3), (200, 300, 3)])
def test_shape_is_kept(shape: tuple[int, ...]) -> None:
    image = np.full(shape, 0.2, np.float32)
    shown = to_srgb8(image)
    assert shown.shape == shape
    assert shown.dtype == np.uint8
    assert (shown == 124).all()


def test_what_is_no_light_is_black() -> None:
    """NaN and negatives are black, infinity is white; nothing warns."""
    bad = np.float32([np.nan, -np.inf, -1.0, -0.0, np.inf, 1e30])
    np.testing.assert_array_equal(to_srgb8(bad), [0, 0, 0, 0, 255, 255])
    np.testing.assert_allclose(to_srgb(bad), [0, 0, 0, 0, 1, 1], atol=1e-12)
