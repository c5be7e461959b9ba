"""Spectra to linear sRGB, against another way to integrate, and against published colours."""

from __future__ import annotations

import colour
import numpy as np
import pytest

from engine.brdf.acquisition.spectrum import linear_srgb

TENS = np.arange(400.0, 701.0, 10.0)


@pytest.mark.parametrize(
    "wavelengths", [[550.0], [450.0, 600.0], TENS.tolist(), [380.0, 391.5, 500.0, 777.0, 900.0]]
)
def test_a_white_diffuser_is_white(wavelengths: list[float]) -> None:
    white = linear_srgb(np.array(wavelengths), np.full((1, len(wavelengths)), 0.7))
    np.testing.assert_allclose(white, [[0.7, 0.7, 0.7]], rtol=1e-12)


def test_it_is_linear() -> None:
    spectra = np.random.default_rng(1).random((2, len(TENS)))
    both = linear_srgb(TENS, spectra)
    np.testing.assert_allclose(linear_srgb(TENS, [2, 3] @ spectra), [2, 3] @ both, rtol=1e-12)


def test_against_sums_over_the_instruments_steps() -> None:
    """Ten-nanometre sums of the tables, the textbook's way, for smooth spectra."""
    observer = colour.MSDS_CMFS["CIE 1931 2 Degree Standard Observer"]
    light = colour.SDS_ILLUMINANTS["D65"]
    weights = np.array([np.asarray(observer[w]) * light[w] for w in TENS])
    weights /= weights[:, 1].sum()
    # IEC 61966-2-1, linear sRGB from XYZ.
    matrix = np.array(
        [[3.2406, -1.5372, -0.4986], [-0.9689, 1.8758, 0.0415], [0.0557, -0.2040, 1.0570]]
    )
    spectra = 0.5 + 0.4 * np.sin(TENS / 60 + np.arange(5)[:, None])
    np.testing.assert_allclose(linear_srgb(TENS, spectra), spectra @ weights @ matrix.T, atol=4e-3)


@pytest.mark.parametrize(
    "patch", ["dark skin", "foliage", "blue flower", "red", "yellow", "magenta"]
)
def test_published_colours_of_a_chart(patch: str) -> None:
    """sRGB values of the ColorChecker as its maker published them for D65, in 8 bits.

    They are those of an average chart, its spectra those of another: a few steps apart.
    """
    published = {
        "dark skin": (115, 82, 68),
        "foliage": (87, 108, 67),
        "blue flower": (133, 128, 177),
        "red": (175, 54, 60),
        "yellow": (231, 199, 31),
        "magenta": (187, 86, 149),
    }
    spectrum = colour.SDS_COLOURCHECKERS["BabelColor Average"][patch]
    spectrum = spectrum.copy().align(colour.SpectralShape(400, 700, 10))
    rgb = linear_srgb(TENS, spectrum.values[None])[0]
    coded = np.where(rgb < 0.0031308, 12.92 * rgb, 1.055 * np.maximum(rgb, 0) ** (1 / 2.4) - 0.055)
    assert np.abs(255 * coded - published[patch]).max() < 9


def test_a_pure_colour_lies_outside() -> None:
    assert linear_srgb(TENS, (TENS == 500)[None] * 1.0).min() < 0
