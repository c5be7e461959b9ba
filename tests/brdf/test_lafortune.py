"""Lafortune's lobes against Phong's, and the published fits."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.materials import BLACK, direction, hemisphere, model_and_row

from engine.brdf import albedo, albedo_diagnosis, evaluate, hemispherical_albedo, pdf
from engine.brdf.diffuse import Diffuse
from engine.brdf.lafortune import Lafortune, Lobe
from engine.brdf.phong import Phong
from engine.brdf.published import CLAY, PUBLISHED, SKIN


def phong_lobe(specular: tuple[float, float, float], exponent: float) -> Lobe:
    """Phong's lobe: |C|^n = k_s (n + 2) / 2π."""
    c = tuple((k * (exponent + 2) / (2 * np.pi)) ** (1 / exponent) for k in specular)
    return Lobe(xy=tuple(-x for x in c), z=c, exponent=(exponent,) * 3)


@pytest.mark.parametrize("exponent", [1.0, 7.0, 50.0, 1000.0])
def test_a_mirroring_lobe_is_phongs(exponent: float) -> None:
    diffuse, specular = (0.5, 0.3, 0.1), (0.1, 0.2, 0.3)
    ours = Lafortune(diffuse=diffuse, lobes=(phong_lobe(specular, exponent),))
    phong = Phong(diffuse=diffuse, specular=specular, exponent=exponent)
    rng = np.random.default_rng(6)
    wo = hemisphere(rng, 300)
    wi = np.concatenate([hemisphere(rng, 300), wo * (-1, -1, 1)])
    wo = np.concatenate([wo, wo])
    there, back = evaluate(*model_and_row(ours), wi, wo), evaluate(*model_and_row(phong), wi, wo)
    np.testing.assert_allclose(there, back, rtol=5e-4, atol=1e-9)


def test_lobes_add_up() -> None:
    """Three lobes are the sum of each alone, less the bases counted twice."""
    wi, wo = hemisphere(np.random.default_rng(7), 200), direction(50)
    whole = evaluate(*model_and_row(SKIN), wi, wo)
    parts = [
        evaluate(*model_and_row(Lafortune(diffuse=BLACK, lobes=(lobe,))), wi, wo)
        for lobe in SKIN.lobes
    ]
    base = evaluate(*model_and_row(Diffuse(diffuse=SKIN.diffuse)), wi, wo)
    np.testing.assert_allclose(whole, base + sum(parts), rtol=1e-9)


def test_without_lobes_it_is_lambert() -> None:
    bare, lambert = Lafortune(lobes=()), Diffuse()
    wi, wo = hemisphere(np.random.default_rng(8), 50), direction(50)
    assert (bare.row()[3:6] == 0).all()
    for function in (evaluate, pdf):
        np.testing.assert_allclose(
            function(*model_and_row(bare), wi, wo), function(*model_and_row(lambert), wi, wo)
        )


def test_specular_dims_the_lobes() -> None:
    wi, wo = hemisphere(np.random.default_rng(9), 50), direction(50)
    row = SKIN.row()
    half = Lafortune(**SKIN.model_dump(exclude={"specular"}), specular=(0.5, 0.25, 0.0)).row()
    dark = Lafortune(**SKIN.model_dump(exclude={"specular"}), specular=BLACK).row()
    model, _ = model_and_row(SKIN)
    full, some, none = (evaluate(model, r, wi, wo) for r in (row, half, dark))
    np.testing.assert_allclose(some - none, (full - none) * (0.5, 0.25, 0.0), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(("name", "expected"), [("clay", 0.41), ("skin", 0.485)])
def test_published_fits_are_plausible(name: str, expected: float) -> None:
    """Brighter towards grazing angles, as measured, and never above one.

    A wrong sign or digit among their 27 numbers shows here.
    """
    material = PUBLISHED[name]
    wo = np.stack([direction(a) for a in (0, 30, 60, 75, 85, 89)])
    red = albedo(*model_and_row(material), wo)[:, 0]
    assert red.max() < 0.75
    assert (np.diff(red[2:]) > 0).all()
    assert hemispherical_albedo(*model_and_row(material))[0, 0] == pytest.approx(expected, abs=0.01)
    assert albedo_diagnosis(name, *model_and_row(material)) is None


def test_clay_has_an_off_specular_peak() -> None:
    """What Phong's model cannot do and this one is for: seen at 70° it is brightest beyond 70°."""
    theta = np.arange(30, 90)
    wi = np.stack([direction(float(a), 200.0) for a in theta])
    value = evaluate(*model_and_row(CLAY), wi, direction(70.0, 20.0))[:, 0]
    assert theta[value.argmax()] > 72


def test_bright_lobes_are_told_of() -> None:
    bright = Lafortune(lobes=(phong_lobe((0.9, 0.9, 0.9), 50.0),))
    told = albedo_diagnosis("pot", *model_and_row(bright))
    assert told is not None
    assert told.size == pytest.approx(0.4, abs=0.01)
