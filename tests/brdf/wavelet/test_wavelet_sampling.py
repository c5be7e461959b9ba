"""Samples of codes of every symmetry against their density, over the cells of the square."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.materials import direction
from brdf.wavelet.sources import SOURCES, Formula, lobe
from numpy.typing import NDArray
from scipy.stats import chi2

from engine.brdf import albedo, evaluate, hemispherical_albedo, measured, pdf, sample
from engine.brdf.base import ROW, SPECULAR
from engine.brdf.measured import Measured
from engine.brdf.table import INDEX
from engine.brdf.wavelet.tabulate import Source
from engine.numerics.tangent_poles import coordinates, directions

MODEL = INDEX[Measured]
CELLS, WITHIN, SAMPLES = 24, 8, 60_000
EYES = [(0.0, 0.0), (40.0, 20.0), (80.0, 200.0), (89.0, 90.0)]
TESTS = len(SOURCES) * len(EYES)


def row_of(source: Source, bits: int = 3) -> NDArray[np.float32]:
    row = np.zeros(ROW, np.float32)
    row[SPECULAR : SPECULAR + 3] = 1
    measured.fill(row, measured.encoded(source, bits))
    return row


@pytest.mark.parametrize("name", SOURCES)
@pytest.mark.parametrize("eye", EYES, ids=str)
def test_samples_fall_as_the_density_says(name: str, eye: tuple[float, float]) -> None:
    """Of a code nothing is lost below the horizon, and the density is 1 in all."""
    row, wo = row_of(SOURCES[name]), direction(*eye)
    place = (np.arange(CELLS * WITHIN) + 0.5) / (CELLS * WITHIN)
    wi = directions(place[:, None], place[None, :]).reshape(-1, 3)
    # dω is sin φ dθ dφ.
    area = np.sqrt(1 - wi[:, 1] ** 2) * (np.pi / (CELLS * WITHIN)) ** 2
    fine = (pdf(MODEL, row, wi, wo) * area).reshape(CELLS, WITHIN, CELLS, WITHIN)
    expected = SAMPLES * fine.sum(axis=(1, 3)).ravel()
    assert expected.sum() == pytest.approx(SAMPLES, rel=1e-3)
    found = sample(MODEL, row, wo, np.random.default_rng(5).random((SAMPLES, 3)))
    assert (found[:, 2] > 0).all()
    u, v = (np.array([coordinates(w) for w in found]).T * CELLS).astype(int).clip(0, CELLS - 1)
    observed = np.bincount(u * CELLS + v, minlength=CELLS * CELLS)
    order = np.argsort(expected)
    e, o = expected[order], observed[order]
    few = int(np.searchsorted(np.cumsum(e), 10.0)) + 1
    e, o = np.append(e[:few].sum(), e[few:]), np.append(o[:few].sum(), o[few:])
    assert len(e) > 100
    statistic = ((o - e) ** 2 / e).sum()
    assert chi2.sf(statistic, len(e) - 1) > 1 - (1 - 0.01) ** (1 / TESTS)


@pytest.mark.parametrize("name", SOURCES)
def test_weights_of_samples_are_nearly_even(name: str) -> None:
    """The density follows what is reflected, so that an estimate by it has little noise.

    A sample's f cos θ / pdf varies by 2.9 % of its mean, 6.6 and 6.5 % in this order.
    """
    row, wo = row_of(SOURCES[name], 4), direction(40)
    wi = sample(MODEL, row, wo, np.random.default_rng(6).random((4000, 3)))
    weight = evaluate(MODEL, row, wi, wo).mean(axis=1) * wi[:, 2] / pdf(MODEL, row, wi, wo)
    assert weight.std() < 0.09 * weight.mean()
    assert weight.mean() == pytest.approx(albedo(MODEL, row, wo).mean(), rel=0.02)


def test_the_albedo_of_a_code_without_mirrors_is_that_of_all_quarters() -> None:
    """Light from everywhere, of a grain that lies in one quarter and its opposite alone."""
    source = Formula(lobe((3, 60, 1.0), np.pi / 4), False)
    row = row_of(source, 4)
    found = hemispherical_albedo(MODEL, row)[0]
    k = np.arange(400)
    z, phi = np.sqrt((k + 0.5) / 400), 2.399963 * k
    r = np.sqrt(1 - z * z)
    wo = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
    expected = albedo(MODEL, row, wo).mean(axis=0)
    # That of one quarter alone is 3 % off.
    np.testing.assert_allclose(found, expected, rtol=0.008)
