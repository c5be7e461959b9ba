"""The kernels against the transform in plain arrays, their symmetries, and what levels keep."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.wavelet.sources import ISOTROPIC, MATT, SOURCES, hemisphere, near_mirror
from numba import njit

from engine.brdf import library
from engine.brdf.wavelet import layout
from engine.brdf.wavelet.encoding import Encoded, Target, encode
from engine.brdf.wavelet.synthesis import synthesise
from engine.brdf.wavelet.tabulate import Source, grid_for, incident, outgoing, tabulate
from engine.numerics.vec import vec

every_source = pytest.mark.parametrize("name", SOURCES)


@njit(cache=True)
def _values(high, low, wi, wo, level, out):
    a = library.find(high, low)
    for i in range(len(wi)):
        out[i] = synthesise(a, vec(wi, i), vec(wo, i), level)


def values(one: Encoded, wi: np.ndarray, wo: np.ndarray, level: int = 0) -> np.ndarray:
    out = np.zeros((len(wi), 3))
    _values(*library.file(one.data), np.ascontiguousarray(wi), np.ascontiguousarray(wo), level, out)
    return out


def encoded(source: Source, bits: int = 4) -> Encoded:
    grid = grid_for(source, bits)
    return encode(tabulate(source, grid, 1), grid, Target(error=None))


@every_source
def test_values_at_samples(name: str) -> None:
    """Between nothing: what was encoded, but for 8 bits."""
    one = encoded(SOURCES[name])
    wo, wi = outgoing(one.grid).reshape(-1, 3), incident(one.grid).reshape(-1, 3)
    rng = np.random.default_rng(1)
    i, o = rng.integers(len(wi), size=4000), rng.integers(len(wo), size=4000)
    wi, wo = wi[i], wo[o]
    expected = SOURCES[name].evaluate(wi, wo)
    found = values(one, wi, wo)
    error = np.abs(found - expected) / expected
    assert error.mean() < 0.005
    assert error.max() < 0.1


@every_source
def test_finer_grids_come_nearer(name: str) -> None:
    """Twice the cells along each angle, about a quarter of the error between samples."""
    rng = np.random.default_rng(2)
    wo = hemisphere(rng, 4000)
    wi = near_mirror(rng, wo, 0.3)
    expected = SOURCES[name].evaluate(wi, wo)
    errors = []
    # The general one of 32 cells is large, and its tree is that of the mirrored one.
    for bits in (3, 4) if name == "general" else (3, 4, 5):
        found = values(encoded(SOURCES[name], bits), wi, wo)
        errors.append(np.linalg.norm(found - expected) / np.linalg.norm(expected))
    assert (np.array(errors[1:]) < 0.5 * np.array(errors[:-1])).all()


def test_isotropic_stays_so() -> None:
    """Both directions turned by any angle, and mirrored: the same value."""
    one, rng = encoded(ISOTROPIC), np.random.default_rng(3)
    wi, wo = hemisphere(rng, 500), hemisphere(rng, 500)
    found = values(one, wi, wo)
    for turn in (0.3, 1.9, 4.0):
        c, s = np.cos(turn), np.sin(turn)
        turned = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]).T
        np.testing.assert_allclose(values(one, wi @ turned, wo @ turned), found, rtol=1e-4)
    np.testing.assert_allclose(values(one, wi * (1, -1, 1), wo * (1, -1, 1)), found, rtol=1e-5)


def test_mirrored_stays_so() -> None:
    one, rng = encoded(SOURCES["mirrored"]), np.random.default_rng(4)
    wi, wo = hemisphere(rng, 500), hemisphere(rng, 500)
    found = values(one, wi, wo)
    for mirror in ((-1, 1, 1), (1, -1, 1), (-1, -1, 1)):
        np.testing.assert_allclose(values(one, wi * mirror, wo * mirror), found, rtol=1e-4)


@every_source
def test_no_seams(name: str) -> None:
    """Across axes, cell borders and mirrors a value goes on without a step, at every level.

    Ways around the sky in ten times as many steps: the largest is about a tenth.
    """
    one, rng = encoded(SOURCES[name]), np.random.default_rng(5)
    directions, heights = hemisphere(rng, 20), rng.uniform(0.1, 1.4, 20)
    for level in range(3):
        largest = []
        for count in (400, 4000):
            theta, phi = np.repeat(heights, count), np.tile(np.linspace(0, 2 * np.pi, count), 20)
            r = np.sin(theta)
            wo = np.stack([r * np.cos(phi), r * np.sin(phi), np.cos(theta)], axis=1)
            found = values(one, np.repeat(directions, count, axis=0), wo, level)
            logs = np.log(found).reshape(20, count, 3)
            largest.append(np.abs(np.diff(logs, axis=1)).max())
        assert largest[1] < 0.2 * largest[0]


@every_source
def test_levels_keep_the_light(name: str) -> None:
    """The mean over all outgoing directions, by cosine, is the same from near and from far.

    Exactly so of the cells; what is left is that between two of them values go in straight lines.
    """
    one, rng = encoded(SOURCES[name], 5), np.random.default_rng(6)
    wo = hemisphere(np.random.default_rng(7), 20_000)
    for wi in hemisphere(rng, 4):
        means = [
            values(one, np.tile(wi, (len(wo), 1)), wo, level).mean(axis=0) for level in range(4)
        ]
        off = np.abs(np.array(means) / means[0] - 1).max(axis=1)
        assert (off <= (0, 0.005, 0.015, 0.04)).all()


def test_matt_is_even_at_every_level() -> None:
    one, rng = encoded(MATT), np.random.default_rng(8)
    wi, wo = hemisphere(rng, 200), hemisphere(rng, 200)
    for level in range(4):
        np.testing.assert_allclose(
            values(one, wi, wo, level), np.tile((0.1, 0.2, 0.3), (200, 1)), rtol=1e-5
        )


@every_source
def test_grazing_and_poles(name: str) -> None:
    """Along the horizon, at the poles and straight above: finite, and near the formula's order."""
    one = encoded(SOURCES[name])
    z = np.array([1e-12, 1e-6, 1e-3, 0.02, 1.0])
    phi = np.linspace(0, 2 * np.pi, 17)
    z, phi = (a.ravel() for a in np.meshgrid(z, phi))
    r = np.sqrt(1 - z * z)
    edge = np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=1)
    wi, wo = np.repeat(edge, len(edge), axis=0), np.tile(edge, (len(edge), 1))
    for level in range(4):
        found = values(one, wi, wo, level)
        assert np.isfinite(found).all()
        assert (found >= 0).all()
        assert found.max() <= 1.3


def test_key_without_bytes_finds_nothing() -> None:
    assert library.filed(1.0, 2.0) is None
    assert _address(1.0, 2.0) == 0
    one = encoded(MATT)
    key = library.file(one.data)
    assert key == library.file(one.data.copy())
    assert _address(*key) != 0
    assert layout.block(library.filed(*key)).header[layout.SYMMETRY] == layout.ISOTROPIC


@njit(cache=True)
def _address(high, low):
    return library.find(high, low)
