"""Cook-Torrance against the closed forms, the formula written out, and another renderer."""

from __future__ import annotations

import mitsuba
import numpy as np
import pytest
from brdf.materials import BLACK, direction, hemisphere, model_and_row
from numpy.typing import NDArray
from scipy.integrate import quad

from engine.brdf import albedo, evaluate, hemispherical_albedo, pdf, sample
from engine.brdf.cook_torrance import CookTorrance
from engine.brdf.table import INDEX

WHITE = (1.0, 1.0, 1.0)
# Slopes that float32 holds exactly, from a mirror's to a rough one's.
SLOPES = (0.015625, 0.0625, 0.25, 0.5, 1.0)
ANGLES = (0.0, 30.0, 50.0, 60.0, 70.0, 80.0, 88.0, 89.9)
every_slope = pytest.mark.parametrize("m", SLOPES)


def facets(m: float, colour: tuple[float, float, float] = WHITE) -> CookTorrance:
    """The lobe alone."""
    return CookTorrance(diffuse=BLACK, specular=colour, roughness=m)


def distribution(m: float, tangent: NDArray[np.float64]) -> NDArray[np.float64]:
    """D at angles θ_h from the normal, given tan θ_h: from light that is sent straight back.

    Facets that face both directions reflect D G / (4 cos² θ_h), with G = min(1, 2 cos² θ_h).
    """
    z = 1 / np.sqrt(1 + tangent**2)
    h = np.stack([tangent * z, 0 * z, z], axis=1)
    value = evaluate(*model_and_row(facets(m)), h, h)[:, 0]
    return value * 4 * z**2 / np.minimum(1, 2 * z**2)


@every_slope
def test_facets_cover_the_surface_and_have_the_slope(m: float) -> None:
    """∫ D cos θ_h dh = 1 and ∫ D cos θ_h tan² θ_h dh = m², whatever the formula of D."""
    edges = m * np.linspace(0, 8, 20_001)
    tangent = 0.5 * (edges[1:] + edges[:-1])
    # On the plane of slopes, dh = cos³ θ_h tan θ_h d(tan θ_h) dφ.
    ring = 2 * np.pi * tangent * np.diff(edges) / (1 + tangent**2) ** 1.5
    covered = distribution(m, tangent) / np.sqrt(1 + tangent**2) * ring
    assert covered.sum() == pytest.approx(1, rel=1e-6)
    assert (covered * tangent**2).sum() == pytest.approx(m * m, rel=1e-6)


@every_slope
def test_against_the_formula_written_out(m: float) -> None:
    """With vectors, term by term: random pairs, pairs about each other's mirror image, grazing."""
    rng = np.random.default_rng(3)
    wo = hemisphere(rng, 3000)
    wo[2000:, 2] = 1e-4 + 1e-3 * wo[2000:, 2]
    wi = hemisphere(rng, 3000)
    wi[1000:] = wo[1000:] * (-1, -1, 1) + rng.normal(0, m, (2000, 3)) * wo[1000:, 2:]
    wi, wo = (w / np.linalg.norm(w, axis=1, keepdims=True) for w in (wi, wo))
    # Lower directions leave the products below without digits.
    kept = np.minimum(wi[:, 2], wo[:, 2]) > 3e-5
    wi, wo = wi[kept], wo[kept]
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    # The cosine has no digits of small angles.
    theta = np.arctan2(np.hypot(h[:, 0], h[:, 1]), h[:, 2])
    d = np.exp(-((np.tan(theta) / m) ** 2)) / (np.pi * m**2 * np.cos(theta) ** 4)
    oh = np.einsum("ij,ij->i", h, wo)
    g = np.minimum(1, 2 * h[:, 2] / oh * np.minimum(wi[:, 2], wo[:, 2]))
    f = 0.25 + 0.75 * (1 - oh) ** 5
    expected = f * d * g / (4 * wi[:, 2] * wo[:, 2])
    assert (d > 1e-3 * d.max()).sum() > 1000
    found = evaluate(*model_and_row(facets(m, (0.25,) * 3)), wi, wo)[:, 0]
    np.testing.assert_allclose(found, expected, rtol=1e-6, atol=1e-30)


@every_slope
def test_samples_have_the_density_of_the_half_vectors(m: float) -> None:
    """Of facets seen from above: exp(-tan² θ_h / m²) are steeper than θ_h, evenly all round."""
    u = np.random.default_rng(4).random((2000, 3))
    wi = sample(*model_and_row(facets(m)), direction(0), u)
    # wo = n, so h = n + wi, also where wi is below.
    h = wi + direction(0)
    steep = np.exp(-(h[:, 0] ** 2 + h[:, 1] ** 2) / (m * h[:, 2]) ** 2)
    np.testing.assert_allclose(steep, 1 - u[:, 0], rtol=1e-6, atol=1e-9)
    turn = np.arctan2(h[:, 1], h[:, 0]) / (2 * np.pi) % 1
    np.testing.assert_allclose(turn, u[:, 1], atol=1e-6)


@every_slope
def test_reflects_its_closed_form_from_above(m: float) -> None:
    """White facets seen along the normal: ∫ min(1, 2 cos 2θ_h) exp(-t) dt, t = tan² θ_h / m²."""

    def kept(t: float) -> float:
        s = m * m * t
        return min(1.0, 2 * (1 - s) / (1 + s)) * np.exp(-t)

    last = min(1 / m**2, 60.0)
    expected = quad(kept, 0, last, points=[min(1 / (3 * m * m), last)])[0]
    reflected = albedo(*model_and_row(facets(m)), direction(0), points=1 << 17)[0, 0]
    assert reflected == pytest.approx(expected, abs=2e-4)


def test_facets_never_reflect_more_than_they_receive() -> None:
    """White ones keep all when smooth; the rougher, the less of light from everywhere."""
    wo = np.stack([direction(angle) for angle in ANGLES])
    for m in (0.0, *SLOPES):
        assert albedo(*model_and_row(facets(m)), wo, points=1 << 17).max() <= 1 + 5e-4
    rows = np.stack([facets(m).row() for m in (0.0, *SLOPES)])
    all_round = hemispherical_albedo(INDEX[CookTorrance], rows)[:, 0]
    assert all_round[0] == pytest.approx(1, abs=1e-3)
    assert (np.diff(all_round) < 0).all()
    assert all_round[-1] == pytest.approx(0.663, abs=5e-3)
    above = albedo(INDEX[CookTorrance], rows, direction(0))[:, 0]
    np.testing.assert_allclose(above[-2:], (0.89, 0.45), atol=5e-3)


def test_a_white_base_adds_no_more_than_is_said() -> None:
    """0.4 % at worst, so that no scene needs to measure it."""
    wo = np.stack([direction(angle) for angle in ANGLES])
    most = 0.0
    for m in (0.0, 0.07, 0.1, 0.13, 0.16, 0.3, 0.6, 1.0):
        for specular in (0.01, 0.02, 0.04, 0.1, 0.3, 1.0):
            white = CookTorrance(diffuse=WHITE, specular=(specular,) * 3, roughness=m)
            most = max(most, albedo(*model_and_row(white), wo, points=1 << 15).max())
    assert most == pytest.approx(1.0036, abs=5e-4)


@pytest.mark.parametrize("m", [0.1, 0.3, 0.6])
def test_against_mitsuba(m: float) -> None:
    """Beckmann's facets with F = 1: density everywhere, value where nothing is blocked.

    Mitsuba has the masking of Smith. By its formula all is seen where cot θ > 1.6 m, as all is here
    where G = 1.
    """
    mitsuba.set_variant("scalar_rgb")
    theirs = mitsuba.load_dict(
        {
            "type": "roughconductor",
            "distribution": "beckmann",
            "alpha": m,
            "material": "none",
            "sample_visible": False,
        }
    )
    context, seen = mitsuba.BSDFContext(), mitsuba.SurfaceInteraction3f()
    rng = np.random.default_rng(8)
    model, row = model_and_row(facets(m))
    compared = 0
    for angle in (0.0, 30.0, 65.0):
        wo = direction(angle)
        wi = sample(model, row, wo, rng.random((200, 3)))
        wi = wi[wi[:, 2] > 1e-3]
        seen.wi = mitsuba.Vector3f(*wo)
        pairs = [mitsuba.Vector3f(*w) for w in wi]
        density = [theirs.pdf(context, seen, w) for w in pairs]
        np.testing.assert_allclose(pdf(model, row, wi, wo), density, rtol=2e-3)
        h = (wi + wo) / np.linalg.norm(wi + wo, axis=1, keepdims=True)
        open_groove = 2 * h[:, 2] * np.minimum(wi[:, 2], wo[2]) > h @ wo
        z = np.minimum(wi[:, 2], wo[2])
        free = open_groove & (z / np.sqrt(1 - z * z) > 1.6 * m)
        value = np.array([theirs.eval(context, seen, w)[0] for w in pairs])
        ours = evaluate(model, row, wi, wo)[:, 0] * wi[:, 2]
        np.testing.assert_allclose(ours[free], value[free], rtol=2e-3)
        compared += free.sum()
    assert compared > 100
