"""Poulin-Fournier against a trace of its profile, closed forms, limits, and its own sampler."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest
from brdf.materials import BLACK, direction, hemisphere, model_and_row
from numpy.typing import NDArray
from scipy.integrate import quad

from engine.brdf import albedo, evaluate, hemispherical_albedo, pdf, sample
from engine.brdf.base import GRAIN
from engine.brdf.blinn_phong import BlinnPhong, normalisation
from engine.brdf.poulin_fournier import PoulinFournier
from engine.brdf.table import INDEX

WHITE = (1.0, 1.0, 1.0)
FINE = 40_001  # facets of a traced cylinder, and of a floor
SHAPES = [
    {"distance": d, "height": h}
    for d, h in itertools.product((0.5, 2.0, 6.0), (1.0, 0.1, -0.3, -1.0))
]


def matt(**fields: Any) -> PoulinFournier:
    return PoulinFournier(diffuse=WHITE, specular=BLACK, **fields)


def gloss(**fields: Any) -> PoulinFournier:
    return PoulinFournier(diffuse=BLACK, specular=WHITE, **fields)


class Profile:
    """One period of the surface, cut into facets from left to right."""

    def __init__(self, distance: float, height: float) -> None:
        rise = abs(height)
        edge = np.arcsin(min(distance / 2, np.sqrt(rise * (2 - rise))))
        side = np.sign(height)
        lean = edge * np.linspace(-1, 1, FINE) * side
        step = np.full(FINE, 2 * edge / (FINE - 1))
        step[[0, -1]] /= 2
        rest = max(0.0, distance - 2 * np.sin(edge))
        level = np.linspace(0, rest, FINE + 2)[1:-1]
        self.distance = distance
        self.y = np.concatenate([side * np.sin(lean), np.sin(edge) + level])
        self.z = np.concatenate([side * (np.cos(lean) - np.cos(edge)), 0 * level])
        self.normal = np.stack(
            [np.append(np.sin(lean), 0 * level), np.append(np.cos(lean), 0 * level + 1)]
        )
        self.area = np.append(step, np.full(FINE, rest / FINE))

    def reached(self, w: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Which facets face w and are not hidden by any to its side, in this period or another.

        Across a ray that comes from y > 0, a facet is hidden by what lies before and below it.
        """
        y, z = (self.y, self.z) if w[1] >= 0 else (-self.y, self.z)
        offset = y * w[2] - z * abs(w[1])
        order = np.argsort(y, kind="stable")
        sorted_offset = offset[order]
        before = np.minimum.accumulate(sorted_offset[::-1])[::-1]
        before = np.minimum(np.append(before[1:], np.inf), offset.min() + self.distance * w[2])
        free = np.zeros(len(y), bool)
        free[order] = sorted_offset <= before + 1e-12
        return free & (self.normal.T @ w[1:] > 0)

    def brdf(self, material: PoulinFournier, wi: Any, wo: Any) -> float:
        """The integral of the docstring, over facets one by one."""
        h = (wi + wo) / np.linalg.norm(wi + wo)
        a, b, c = (np.maximum(0, self.normal.T @ w[1:]) for w in (wi, wo, h))
        n = material.exponent
        f = material.diffuse[0] / np.pi
        f = f + material.specular[0] * normalisation.py_func(n) * c**n
        both = self.reached(wi) & self.reached(wo)
        return float((f * a * b * self.area)[both].sum() / (wi[2] * wo[2] * self.distance))


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: f"{s['distance']:g}-{s['height']:g}")
def test_against_a_trace_of_the_profile(shape: dict[str, float]) -> None:
    """Light that meets one facet: random pairs, mirrored ones, and from one side near the horizon.

    A facet at the border of the shade is in it or not, which is what the two may differ by.
    """
    rng, profile = np.random.default_rng(1), Profile(**shape)
    wi, wo = hemisphere(rng, 18), hemisphere(rng, 18)
    wo[6:12] = wi[6:12] * (-1, -1, 1) + rng.normal(0, 0.1, (6, 3)) * wi[6:12, 2:]
    wo[12:] = wi[12:] * (1, 1, 0.3) + (0, 0, 0.01)
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    for exponent in (0.0, 12.0, 500.0):
        material = PoulinFournier(exponent=exponent, **shape)
        found = evaluate(*model_and_row(material), wi, wo)[:, 0]
        expected = [profile.brdf(material, *pair) for pair in zip(wi, wo, strict=True)]
        np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize("exponent", [0.0, 1.0, 5.0, 30.0, 200.0, 500.0])
def test_the_quadrature_does_not_show(exponent: float) -> None:
    """The lobe of low cylinders against an adaptive integral, as the light moves across them."""
    material = gloss(exponent=exponent, distance=1.2, height=0.2)  # touch; all is seen up to 53°
    edge = np.arcsin(0.6)
    e, worst = exponent, 0.0
    wo = direction(20, 30)
    for angle in np.linspace(-52, 52, 41):
        wi = direction(angle, 80)
        h = (wi + wo) / np.linalg.norm(wi + wo)

        def facet(t: float, wi: Any = wi, h: Any = h) -> float:
            n = np.array([0.0, np.sin(t), np.cos(t)])
            return max(0.0, n @ h) ** e * max(0.0, n @ wi) * max(0.0, n @ wo)

        peak = np.clip(np.arctan2(h[1], h[2]), -edge, edge)
        whole = sum(quad(facet, *ends, epsabs=1e-13)[0] for ends in ((-edge, peak), (peak, edge)))
        expected = normalisation.py_func(e) * whole / (1.2 * wi[2] * wo[2])
        found = evaluate(*model_and_row(material), wi, wo)[0, 0]
        worst = max(worst, abs(found / expected - 1))
    assert worst < 1e-4


def test_without_height_it_is_blinn_phong() -> None:
    rng = np.random.default_rng(2)
    wi, wo = hemisphere(rng, 500), hemisphere(rng, 500)
    fields: dict[str, Any] = {"diffuse": (0.2, 0.3, 0.4), "specular": (0.5, 0.4, 0.3)}
    flat = BlinnPhong(exponent=80, **fields)
    for distance in (0.3, 2.0, 9.0):
        level = PoulinFournier(exponent=80, distance=distance, height=0, **fields)
        np.testing.assert_allclose(
            evaluate(*model_and_row(level), wi, wo),
            evaluate(*model_and_row(flat), wi, wo),
            rtol=1e-6,
        )


@pytest.mark.parametrize("height", [1.0, -1.0])
def test_half_cylinders_from_above(height: float) -> None:
    """Touching, with light from above too: ∫ cos² θ dθ / 2 = π/4 of a level surface."""
    above = direction(0)
    value = evaluate(*model_and_row(matt(height=height)), above, above)[0, 0]
    assert value == pytest.approx(0.25, rel=1e-6)


def test_matt_half_cylinders_reflect_what_their_facets_see_of_the_sky() -> None:
    """From above. In a groove every facet sees the opening under a right angle."""

    def sky(theta: float) -> float:
        a = np.pi / 4 - theta / 2
        return 0.5 * (np.sin(a) + np.sin(np.pi / 2 - a)) * np.cos(theta)

    expected = quad(sky, -np.pi / 2, np.pi / 2)[0] / 2
    assert expected == pytest.approx(2 / 3)
    found = albedo(*model_and_row(matt(height=-1)), direction(0), points=1 << 15)[0, 0]
    assert found == pytest.approx(expected, abs=1e-3)


def test_close_cylinders_become_level() -> None:
    """Where they cut each other low down, only little is left of their shape."""
    wi, wo = direction(30, 200), direction(40, 50)
    level = evaluate(*model_and_row(matt(height=0)), wi, wo)[0, 0]
    for height in (1.0, -1.0):
        off = [
            abs(evaluate(*model_and_row(matt(distance=d, height=height)), wi, wo)[0, 0] - level)
            for d in (1.6, 0.8, 0.4, 0.2)
        ]
        assert (np.diff(off) < 0).all()
        assert off[-1] < 5e-3 * level


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: f"{s['distance']:g}-{s['height']:g}")
def test_never_reflects_more_than_it_receives(shape: dict[str, float]) -> None:
    wo = np.stack(
        [direction(a, phi) for a in (0, 40, 60, 80, 88, 89.9) for phi in (0.0, 45.0, 90.0)]
    )
    for material in (matt(**shape), gloss(**shape), gloss(exponent=5, **shape)):
        reflected = albedo(*model_and_row(material), wo)
        assert reflected.max() <= 1 + 2e-3
        assert reflected.min() > 0


def test_what_is_lost_between_the_facets() -> None:
    """The figures of the docstring, under even light."""
    for material, kept in (
        (matt(height=1), 0.82),
        (gloss(height=1), 0.44),
        (matt(height=-1), 0.64),
        (gloss(height=-1), 0.41),
    ):
        found = hemispherical_albedo(*model_and_row(material))[0, 0]
        assert found == pytest.approx(kept, abs=5e-3)


def test_grain_turns_the_cylinders() -> None:
    """A row with its grain turned is the material seen in a frame turned the other way."""
    rng = np.random.default_rng(4)
    wi, wo = hemisphere(rng, 200), hemisphere(rng, 200)
    model, row = model_and_row(gloss())
    c, s = np.cos(np.radians(25.0)), np.sin(np.radians(25.0))
    turn, there = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]), row.copy()
    there[GRAIN:] = c, s
    for function in (evaluate, pdf):
        here = function(model, row, wi, wo)
        found = function(model, there, wi @ turn.T, wo @ turn.T)
        np.testing.assert_allclose(found, here, rtol=1e-4, atol=1e-9)
    u = rng.random((200, 3))
    np.testing.assert_allclose(
        sample(model, there, wo @ turn.T, u), sample(model, row, wo, u) @ turn.T, atol=1e-5
    )


@pytest.mark.parametrize("shape", SHAPES, ids=lambda s: f"{s['distance']:g}-{s['height']:g}")
@pytest.mark.parametrize("exponent", [0.0, 10.0, 500.0])
def test_samples_weigh_about_the_same(shape: dict[str, float], exponent: float) -> None:
    """f cos θ_i over the density never grows out of hand, or pictures would have specks."""
    material = gloss(exponent=exponent, **shape)
    model, row = model_and_row(material)
    u = np.random.default_rng(5).random((4000, 3))
    for angle, phi in itertools.product((0.0, 50.0, 80.0), (0.0, 60.0, 90.0)):
        wo = direction(angle, phi)
        wi = sample(model, row, wo, u)
        wi = wi[wi[:, 2] > 0]
        weight = evaluate(model, row, wi, wo)[:, 0] * wi[:, 2] / pdf(model, row, wi, wo)
        assert weight.max() < 8


def test_row_of_shapes() -> None:
    """θ_m and the floor: cylinders apart, touching, and cut by each other."""
    assert INDEX[PoulinFournier] != INDEX[BlinnPhong]
    for fields, edge, floor in (
        ({"distance": 3.0, "height": 1.0}, np.pi / 2, 1.0),
        ({"distance": 2.0, "height": -1.0}, -np.pi / 2, 0.0),
        ({"distance": 1.0, "height": 1.0}, np.pi / 6, 0.0),
        ({"distance": 4.0, "height": 0.5}, np.pi / 3, 4 - np.sqrt(3)),
    ):
        row = PoulinFournier(**fields).row()
        np.testing.assert_allclose(row[7:9], (edge, floor), rtol=1e-6)
