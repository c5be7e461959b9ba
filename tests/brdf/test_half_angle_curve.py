"""Facets of any distribution: what they cover, what they reflect, and lobes made into curves."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.materials import BLACK, direction, hemisphere, model_and_row, spike
from pydantic import ValidationError
from scipy.integrate import quad

from engine.brdf import Material, albedo, evaluate
from engine.brdf.as_curve import as_curve
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.diffuse import Diffuse
from engine.brdf.ggx import Ggx
from engine.brdf.half_angle_curve import ANGLES_DEGREES, NODES, WEIGHTS, HalfAngleCurve, cover
from engine.brdf.phong import Phong
from engine.brdf.table import INDEX
from engine.errors import EditError
from engine.scene.edits import Edits, edited_materials
from engine.scene.open import open_scene

WHITE = (1.0, 1.0, 1.0)
ANGLES = (0.0, 10.0, 30.0, 40.0, 50.0, 60.0, 65.0, 70.0, 80.0, 88.0, 89.9)
EVERY = np.stack([direction(angle) for angle in ANGLES])


def distribution(material: HalfAngleCurve, angles: np.ndarray) -> np.ndarray:
    """D at half angles, from white facets that light is sent straight back by."""
    white = material.model_copy(update={"diffuse": BLACK, "specular": WHITE})
    z = np.cos(angles)
    h = np.stack([np.sin(angles), 0 * z, z], axis=1)
    value = evaluate(*model_and_row(white), h, h)[:, 0]
    return value * 4 * z**2 / np.minimum(1, 2 * z**2)


def test_even_facets_cover_the_surface() -> None:
    """1 everywhere is D = 1 / π, which covers it once."""
    even = HalfAngleCurve(curve=(1.0,) * NODES)
    np.testing.assert_allclose(distribution(even, np.linspace(0, 1.5, 50)), 1 / np.pi, rtol=1e-6)
    assert cover(even.curve) == pytest.approx(1, abs=1e-12)


def test_cover_is_the_integral() -> None:
    """Σ w_k c_k = ∫ D cos θ_h dh of a curve at random."""
    curve = np.random.default_rng(5).random(NODES)
    material = HalfAngleCurve(curve=tuple(curve / cover(curve)))
    whole = quad(
        lambda t: float(distribution(material, np.array([t]))[0]) * np.cos(t) * np.sin(t),
        0, np.pi / 2, points=np.radians(ANGLES_DEGREES[1:-1]), limit=200,
    )[0]  # fmt: skip
    assert 2 * np.pi * whole == pytest.approx(1, abs=1e-6)


def test_a_curve_goes_through_its_nodes() -> None:
    angles = np.radians(ANGLES_DEGREES[:-1])
    curve = 0.3 + 0.5 * np.random.default_rng(6).random(NODES)
    found = np.pi * distribution(HalfAngleCurve(curve=tuple(curve)), angles)
    np.testing.assert_allclose(found, curve[:-1], rtol=1e-5)


@pytest.mark.parametrize("node", range(NODES))
def test_no_curve_reflects_more_than_it_receives(node: int) -> None:
    """Reflectance is linear in the curve: the worst that covers the surface has one node alone."""
    facets = spike(node, diffuse=BLACK, specular=WHITE)
    assert albedo(*model_and_row(facets), EVERY).max() <= 1.0005
    for f0 in (0.01, 0.04, 0.2, 0.9):
        plastic = spike(node, diffuse=WHITE, specular=(f0,) * 3)
        assert albedo(*model_and_row(plastic), EVERY).max() <= 1.0075


def test_too_much_is_scaled() -> None:
    """Four times too much is the same as all that may be; less than that stays as it is."""
    fitting = spike(9, specular=(0.5,) * 3)
    much = spike(9, cover=4, specular=(0.5,) * 3)
    np.testing.assert_allclose(much.row(), fitting.row(), rtol=1e-6)
    half = spike(9, cover=0.5, specular=(0.5,) * 3)
    assert half.row()[7 + 9] == pytest.approx(0.5 * fitting.row()[7 + 9])


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"curve": [0.5] * 3 + [-0.1] + [0.5] * (NODES - 4)}, ["curve.3", "greater than or equal"]),
        ({"curve": [0.5] * 5 + [float("nan")] + [0.5] * (NODES - 6)}, ["curve.5", "finite"]),
        ({"curve": [float("inf")] + [0.5] * (NODES - 1)}, ["curve.0", "finite"]),
        ({"curve": [0.5] * (NODES - 1)}, ["curve", "at least 22"]),
        ({"curve": [0.5] * (NODES + 1)}, ["curve", "at most 22"]),
        ({"energy": "refuse", "curve": [2] * NODES}, ["curve", "cover 2 times", "'scale'"]),
    ],
    ids=["negative", "nan", "infinite", "short", "long", "too much"],
)
def test_a_bad_curve_says_what(fields: dict[str, object], words: list[str]) -> None:
    with pytest.raises(ValidationError) as refused:
        HalfAngleCurve(**fields)
    for word in words:
        assert word in str(refused.value)
    scene = open_scene("cornell-box")
    change = {"white": {"type": "half_angle_curve", **fields}}
    with pytest.raises(EditError) as edit:
        edited_materials(scene, Edits(materials=change).materials)
    assert str(edit.value.field).startswith("materials.white.curve")


# Relative L2 error of the lobe by its cover, with 22 nodes.
LOBES: list[tuple[Material, float]] = [
    (BlinnPhong(exponent=5, specular=(0.3,) * 3), 0.005),
    (BlinnPhong(exponent=100, specular=(0.3,) * 3), 0.01),
    (BlinnPhong(exponent=1000, specular=(0.3,) * 3), 0.04),
    (CookTorrance(roughness=0.3), 0.01),
    (CookTorrance(roughness=0.05, specular=(0.9, 0.6, 0.3)), 0.04),
    (Ggx(roughness=0.5), 0.01),
    (Ggx(roughness=0.2), 0.05),
]


def density(material: Material, angle: np.ndarray) -> np.ndarray:
    """D by its textbook formula, which covers the surface once."""
    z2 = np.cos(angle) ** 2
    if isinstance(material, BlinnPhong):
        return (material.exponent + 2) / (2 * np.pi) * z2 ** (material.exponent / 2)
    if isinstance(material, CookTorrance):
        m2 = material.roughness**2
        return np.exp(-(np.tan(angle) ** 2) / m2) / (np.pi * m2 * z2**2)
    assert isinstance(material, Ggx)
    a2 = material.roughness**4
    return a2 / (np.pi * (z2 * (a2 - 1) + 1) ** 2)


@pytest.mark.parametrize(
    ("material", "most"), LOBES, ids=[f"{type(m).__name__}-{k}" for k, (m, _) in enumerate(LOBES)]
)
def test_a_lobe_becomes_a_curve(material: Material, most: float) -> None:
    curve = as_curve(material)
    kept = {"emission", "diffuse", "specular"}
    assert curve.model_dump(include=kept) == material.model_dump(include=kept)
    assert cover(curve.curve) == pytest.approx(1, abs=1e-4)
    assert HalfAngleCurve(**{**curve.model_dump(), "energy": "refuse"}).curve == curve.curve
    angle = np.linspace(0, 1.5, 20_001)
    weight = np.sqrt(np.sin(2 * angle))
    true = weight * density(material, angle)
    found = weight * distribution(curve, angle)
    assert np.linalg.norm(found - true) < most * np.linalg.norm(true)


def test_cook_torrance_stays_what_it_was() -> None:
    """Its grooves, Fresnel and base are the curve's too, so only the lobe is approximate."""
    rng = np.random.default_rng(7)
    wo = hemisphere(rng, 4000)
    wi = wo * [-1, -1, 1] + 0.3 * rng.standard_normal((4000, 3))
    wi /= np.linalg.norm(wi, axis=1)[:, None]
    kept = (wi[:, 2] > 0.05) & (wo[:, 2] > 0.05)
    material = CookTorrance(diffuse=(0.2, 0.4, 0.6), specular=(0.3, 0.2, 0.1), roughness=0.3)
    true = evaluate(*model_and_row(material), wi[kept], wo[kept])
    found = evaluate(*model_and_row(as_curve(material)), wi[kept], wo[kept])
    assert np.linalg.norm(found - true) < 0.02 * np.linalg.norm(true)


def test_other_lobes_become_curves_too() -> None:
    """Phong's is as wide as a half-angle one of four times its exponent; matt has the default."""
    assert as_curve(Phong(exponent=25)).curve == as_curve(BlinnPhong(exponent=100)).curve
    brushed = as_curve(AshikhminShirley(exponent_u=100, exponent_v=100))
    np.testing.assert_allclose(brushed.curve, as_curve(BlinnPhong(exponent=100)).curve, atol=1e-3)
    default = HalfAngleCurve()
    assert default.curve == as_curve(BlinnPhong(exponent=50)).curve
    assert as_curve(Diffuse(diffuse=(0.1, 0.2, 0.3))) == HalfAngleCurve(diffuse=(0.1, 0.2, 0.3))
    drawn = spike(7, cover=0.3)
    assert as_curve(drawn) is drawn


@pytest.mark.parametrize("exponent", [0.0, 5.0, 50.0, 500.0])
def test_the_exponent_of_a_curve(exponent: float) -> None:
    assert as_curve(BlinnPhong(exponent=exponent)).exponent == pytest.approx(
        exponent, rel=0.02, abs=0.02
    )


def test_nothing_covered_is_the_base_alone() -> None:
    """Facets that are not there are not sampled, and the base keeps what it gets."""
    bare = spike(0, cover=0, diffuse=WHITE, specular=(0.2,) * 3)
    wo = direction(0)
    assert albedo(INDEX[HalfAngleCurve], bare.row(), wo)[0, 0] == pytest.approx(0.8, abs=2e-3)
    assert WEIGHTS.sum() == pytest.approx(1)
