"""Factored BRDFs where they break: a mirror is not a sum of a few products of maps.

`glossy_prt` (Wang, Tran, Luebke 2006), §3.3.1: for highly specular BRDFs the singular values tend
to become equally large. Phong's lobe alone, sharper and sharper, at the paper's 4 terms and 48 x 48
texels: what it keeps of its light, how much of that is negative, and what the user is told.
"""

from __future__ import annotations

import numpy as np
import pytest

from engine.brdf.base import Material
from engine.brdf.factored import Factored, evaluate
from engine.brdf.factorisation import factor
from engine.brdf.fit import (
    albedo_kept,
    fit_diagnosis,
    fit_of,
    negative_share,
    rms_errors,
    terms_for,
    uniform_pairs,
)
from engine.brdf.non_negative import non_negative
from engine.brdf.phong import Phong
from engine.brdf.published import SKIN
from engine.diagnosis import Diagnosis


def lobe(exponent: float) -> Phong:
    return Phong(diffuse=(0.0, 0.0, 0.0), specular=(0.5, 0.5, 0.5), exponent=exponent)


# Exponent, albedo kept, negative share of the light, relative RMS error: measured.
RINGING = [
    (50.0, 0.838, 0.162, 0.853),
    (200.0, 0.586, 0.170, 0.953),
    (1000.0, 0.321, 0.170, 0.991),
    (5000.0, 0.122, 0.310, 0.997),
]


@pytest.mark.parametrize(("exponent", "kept", "negative", "error"), RINGING)
def test_sharper_and_sharper(exponent: float, kept: float, negative: float, error: float) -> None:
    """Energy goes, a sixth and more of what is left rings below zero, the error nears 1."""
    material = lobe(exponent)
    factored = factor(material)
    each, whole = rms_errors(factored, uniform_pairs(material))
    assert albedo_kept(factored, material)[0] == pytest.approx(kept, abs=0.02)
    assert negative_share(factored) == pytest.approx(negative, abs=0.02)
    assert each[-1] / whole == pytest.approx(error, abs=0.01)
    assert np.isfinite(factored.light).all()


def test_terms_that_would_hold_an_error() -> None:
    """They grow in proportion to the exponent, as the lobe's solid angle shrinks."""
    needed = [terms_for(lobe(n), 0.3, 32)[0] for n in (10.0, 40.0, 160.0)]
    assert needed[0] < needed[1] < needed[2]
    assert 2.5 < needed[2] / needed[1] < 5
    # With so many terms the table is as good as promised.
    material = lobe(10.0)
    each, whole = rms_errors(factor(material, needed[0], 32), uniform_pairs(material))
    assert each[-1] / whole == pytest.approx(0.3, abs=0.08)


def told(name: str, material: Material, factored: Factored, bound: float) -> Diagnosis | None:
    return fit_diagnosis(name, fit_of(material, factored, bound), factored, bound)


def test_what_the_user_is_told() -> None:
    mirror = told("mirror", lobe(2000.0), factor(lobe(2000.0), 4, 24), 0.1)
    assert mirror is not None
    assert mirror.code == "too_glossy_for_terms"
    assert mirror.size > 0.9
    for words in ("'mirror'", "4 terms", "negative and clamped", "would hold 10 %", "finer maps"):
        assert words in mirror.message
    # A lobe that the texels resolve needs terms alone.
    wide = told("satin", lobe(8.0), factor(lobe(8.0), 4, 24), 0.1)
    assert wide is not None
    assert "terms would hold 10 %." in wide.message
    # The error holds: nothing to say.
    assert told("skin", SKIN, factor(SKIN, 16, 32), 0.2) is None


@pytest.mark.parametrize("exponent", [50.0, 1000.0])
def test_non_negative_terms_do_not_ring(exponent: float) -> None:
    """Where ringing is worse than blur: nothing is negative, and more of the light is kept."""
    ours, eigen = non_negative(lobe(exponent), 4, 24), factor(lobe(exponent), 4, 24)
    assert negative_share(ours) == 0
    assert negative_share(eigen) > 0.1
    assert albedo_kept(ours, lobe(exponent))[0] > albedo_kept(eigen, lobe(exponent))[0]


def local(theta: np.ndarray, phi: np.ndarray) -> np.ndarray:
    return np.stack([np.sin(theta) * np.cos(phi), np.sin(theta) * np.sin(phi), np.cos(theta)], -1)


def test_polar_terms_are_as_good_at_their_seam_as_elsewhere() -> None:
    """§6 of the paper could not mend the seam: its textures ended where the azimuth jumps.

    What a lobe that knows no grain reflects between two directions is the same however both are
    turned: terms of a polar map hold it as well with one direction on each side of the seam.
    """
    terms = factor(lobe(10.0), 16, 24, polar=True)
    turns = np.linspace(0, 2 * np.pi, 721)
    seam = np.abs(np.sin(turns) + 1) < 0.01  # eq. 11 jumps at w_x = 0, w_y < 0
    for theta in (0.05, 0.2, 0.6, 1.0):
        wi, wo = (local(np.full(721, theta), turns + off) for off in (-0.05, 0.05))
        found = evaluate(terms, wi, wo)[:, 0]
        off, step = np.abs(found - found.mean()), np.abs(np.diff(found))
        assert off[seam].max() <= 1.01 * off[~seam].max()
        assert step[seam[1:]].max() <= 1.01 * step[~seam[1:]].max()
        assert off.max() < 0.15 * found.mean()
