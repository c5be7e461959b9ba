"""Each model against closed forms, limits and another renderer; what is said of bright ones."""

from __future__ import annotations

import mitsuba
import numpy as np
import pytest
from brdf.materials import BLACK, direction, hemisphere, model_and_row

from engine.brdf import (
    albedo,
    albedo_diagnosis,
    evaluate,
    hemispherical_albedo,
    pdf,
    sample,
)
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.brdf.half_angle_curve import HalfAngleCurve
from engine.brdf.lewis import Lewis
from engine.brdf.phong import Phong
from engine.brdf.table import INDEX, MODELS, MODULES

WHITE = (1.0, 1.0, 1.0)
FACETS = pytest.mark.parametrize("model", [Ggx, CookTorrance])
SHARPNESS = (0.0, 1.0, 7.0, 60.0, 3000.0)


@pytest.mark.parametrize("model", [Phong, BlinnPhong])
@pytest.mark.parametrize("exponent", SHARPNESS)
def test_lobe_reflects_all_at_normal_incidence(
    model: type[Phong] | type[BlinnPhong], exponent: float
) -> None:
    """Both normalisations mean: `specular` is what the lobe reflects of light from above."""
    material = model(diffuse=BLACK, specular=(0.8, 0.4, 0.2), exponent=exponent)
    reflected = albedo(*model_and_row(material), direction(0))[0]
    np.testing.assert_allclose(reflected, (0.8, 0.4, 0.2), atol=2e-3)


def test_phong_lobe_at_an_angle() -> None:
    """A sharp lobe reflects (n + 2) / (n + 1) · cos θ of the light, none of it below."""
    n, angle = 3000.0, 50.0
    material = Phong(diffuse=BLACK, specular=WHITE, exponent=n)
    expected = (n + 2) / (n + 1) * np.cos(np.radians(angle)) * (n + 1) / (n + 2)
    reflected = albedo(*model_and_row(material), direction(angle))[0, 0]
    assert reflected == pytest.approx(expected, abs=1e-3)


def test_one_formula_under_two_names_is_compiled_once() -> None:
    """Lewis's plausible Phong: the same row for the same kernels."""
    fields = {"diffuse": (0.2, 0.3, 0.4), "specular": (0.5, 0.4, 0.3), "exponent": 12.0}
    np.testing.assert_array_equal(Lewis(**fields).row(), Phong(**fields).row())
    assert INDEX[Lewis] == INDEX[Phong]
    assert len(MODULES) == len(set(MODULES)) == len(set(MODELS.values())) < len(MODELS)


def test_blinn_phong_exponent_zero_is_lambert() -> None:
    """Without sharpness the half vector does not matter."""
    wi, wo = hemisphere(np.random.default_rng(5), 50), direction(40)
    material = BlinnPhong(diffuse=BLACK, specular=WHITE, exponent=0)
    value = evaluate(*model_and_row(material), wi, wo)
    np.testing.assert_allclose(value, 1 / np.pi, rtol=1e-12)


@FACETS
def test_facets_without_specular_are_lambert(model: type[Ggx] | type[CookTorrance]) -> None:
    """No interface, no loss: `specular` 0 leaves the base alone."""
    rng = np.random.default_rng(6)
    wi, wo = hemisphere(rng, 200), hemisphere(rng, 200)
    base = model(diffuse=(0.2, 0.5, 0.9), specular=BLACK, roughness=0.2)
    lambert = Diffuse(diffuse=(0.2, 0.5, 0.9))
    np.testing.assert_allclose(
        evaluate(*model_and_row(base), wi, wo), evaluate(*model_and_row(lambert), wi, wo)
    )
    np.testing.assert_allclose(
        pdf(*model_and_row(base), wi, wo), pdf(*model_and_row(lambert), wi, wo)
    )


@FACETS
def test_smooth_facets_reflect_fresnel(model: type[Ggx] | type[CookTorrance]) -> None:
    """At the least roughness facets reflect Schlick's F, and a white base all the rest."""
    facets = model(diffuse=BLACK, specular=(0.04, 0.2, 0.9), roughness=0)
    white = model(diffuse=WHITE, specular=(0.04, 0.2, 0.9), roughness=0)
    for angle in (0.0, 30.0, 60.0, 75.0):
        wo = direction(angle)
        f0 = np.array([0.04, 0.2, 0.9])
        fresnel = f0 + (1 - f0) * (1 - np.cos(np.radians(angle))) ** 5
        np.testing.assert_allclose(albedo(*model_and_row(facets), wo)[0], fresnel, atol=2e-3)
        reflected = albedo(*model_and_row(white), wo, points=2**17)[0]
        np.testing.assert_allclose(reflected, 1, atol=1e-3)


def test_ggx_furnace_loss_grows_with_roughness() -> None:
    """White facets lose the light that bounces between them: none when smooth, most when rough."""
    rough = [0.0, 0.2, 0.4, 0.6, 0.8, 1.0]
    rows = np.stack([Ggx(diffuse=BLACK, specular=WHITE, roughness=r).row() for r in rough])
    kept = hemispherical_albedo(INDEX[Ggx], rows)[:, 0]
    assert kept[0] == pytest.approx(1, abs=2e-3)
    assert (np.diff(kept) < 0).all()
    # What is left at roughness 1 is the whole of single scattering from α = 1.
    assert kept[-1] == pytest.approx(0.41, abs=0.01)
    for angle in (0.0, 45.0, 80.0):
        one = albedo(INDEX[Ggx], rows, direction(angle))[:, 0]
        assert (np.diff(one) < 2e-3).all()
        assert one.min() > 0.3


def test_hemispherical_albedo() -> None:
    """Lambert's is its reflectance; a mirror-like Fresnel's is F0 + (1 - F0) / 21."""
    rows = np.stack([Diffuse(diffuse=(0.1, 0.5, 0.9)).row(), Diffuse(diffuse=WHITE).row()])
    np.testing.assert_allclose(
        hemispherical_albedo(INDEX[Diffuse], rows), [(0.1, 0.5, 0.9), WHITE], atol=1e-6
    )
    glass = Ggx(diffuse=BLACK, specular=(0.04, 0.04, 0.04), roughness=0)
    expected = 0.04 + 0.96 / 21
    assert hemispherical_albedo(*model_and_row(glass))[0, 0] == pytest.approx(expected, abs=1e-3)


@pytest.mark.parametrize("model", [Phong, BlinnPhong, Ggx, CookTorrance, HalfAngleCurve])
def test_density_is_the_mean_of_its_lobes(model: type[Phong]) -> None:
    """`sample` picks a lobe as often as `pdf` says."""
    both, base = model(), Diffuse(diffuse=(0.5, 0.5, 0.5))
    lobe = model(diffuse=BLACK)
    wi, wo = hemisphere(np.random.default_rng(7), 100), direction(40)
    p, q, m = (pdf(*model_and_row(x), wi, wo) for x in (both, base, lobe))
    part = (m - p) / (m - q)
    np.testing.assert_allclose(part, part[0], rtol=1e-6)
    u = np.column_stack([np.full((1000, 2), 0.3), (np.arange(1000) + 0.5) / 1000])
    directions = sample(*model_and_row(both), wo, u)
    based = np.isclose(directions, sample(*model_and_row(base), wo, u[0]), atol=1e-12).all(axis=1)
    assert based.mean() == pytest.approx(part[0], abs=1e-3)


def test_bright_material_is_told_of() -> None:
    """Reflectances that add up to more than 1 are used as they are, and named."""
    bright = Phong(diffuse=(0.5, 0.9, 0.5), specular=(0.5, 0.5, 0.5))
    told = albedo_diagnosis("pot", *model_and_row(bright))
    assert told is not None
    assert told.code == "albedo_above_one"
    assert told.size == pytest.approx(0.4, abs=5e-3)
    for words in ("'pot'", "1.40 times", "green", "0 degrees"):
        assert words in told.message
    np.testing.assert_allclose(
        albedo(*model_and_row(bright), direction(0))[0], (1.0, 1.4, 1.0), atol=5e-3
    )


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.__name__)
def test_ordinary_material_is_not(model: type[Diffuse]) -> None:
    assert albedo_diagnosis("pot", *model_and_row(model())) is None
    if "diffuse" not in model.model_fields:
        return
    half = model(diffuse=(0.5, 0.5, 0.5))
    assert albedo_diagnosis("pot", *model_and_row(half)) is None


@FACETS
def test_white_plastic_is_not_told_of(model: type[Ggx] | type[CookTorrance]) -> None:
    """A coupled base never goes above 1 by more than the quadrature's error."""
    for roughness in (0.0, 0.1, 0.3, 0.5, 1.0):
        white = model(diffuse=WHITE, roughness=roughness)
        assert albedo_diagnosis("wall", *model_and_row(white)) is None


def test_arrays_say_what_does_not_fit() -> None:
    row = Diffuse().row()
    with pytest.raises(ValueError, match=f"outside 0 to {len(MODULES) - 1}"):
        evaluate(len(MODULES), row, direction(0), direction(0))
    with pytest.raises(ValueError, match="shape mismatch"):
        evaluate(0, row, np.zeros((2, 3)), np.zeros((3, 3)))
    assert evaluate(0, row, np.zeros((0, 3)), direction(0)).shape == (0, 3)


@pytest.fixture(scope="module")
def rough_mirror() -> mitsuba.BSDF:
    """Mitsuba's GGX with F = 1, sampled by visible normals; α is 0.36 = 0.6²."""
    mitsuba.set_variant("scalar_rgb")
    return mitsuba.load_dict(
        {
            "type": "roughconductor",
            "distribution": "ggx",
            "alpha": 0.36,
            "material": "none",
            "sample_visible": True,
        }
    )


def test_ggx_against_mitsuba(rough_mirror: mitsuba.BSDF) -> None:
    """Value where one direction is the normal, density everywhere.

    Mitsuba multiplies the masking of both directions where ours is height-correlated: they differ
    unless one of the directions is unmasked. The density holds the masking of wo alone.
    """
    material = Ggx(diffuse=BLACK, specular=WHITE, roughness=0.6)
    context = mitsuba.BSDFContext()
    seen = mitsuba.SurfaceInteraction3f()
    rng = np.random.default_rng(8)
    for angle in (0.0, 30.0, 65.0):
        wo, wi = direction(angle), hemisphere(rng, 50)
        seen.wi = mitsuba.Vector3f(*wo)
        pairs = [mitsuba.Vector3f(*w) for w in wi]
        density = [rough_mirror.pdf(context, seen, w) for w in pairs]
        np.testing.assert_allclose(pdf(*model_and_row(material), wi, wo), density, rtol=1e-3)
        if angle == 0.0:
            value = [rough_mirror.eval(context, seen, w)[0] for w in pairs]
            ours = evaluate(*model_and_row(material), wi, wo)[:, 0] * wi[:, 2]
            np.testing.assert_allclose(ours, value, rtol=1e-3)
