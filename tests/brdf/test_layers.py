"""BRDFs cut into quotients and curves: the sum is the BRDF, its albedo the material's."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.materials import BLACK, LOBES, hemisphere, name_of, spike
from numba import njit

from engine.brdf import hemispherical_albedo, table
from engine.brdf.ashikhmin_shirley import AshikhminShirley
from engine.brdf.base import Material
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.curve_basis import Basis, coefficients, weights_at
from engine.brdf.equivalent_albedo import shares
from engine.brdf.ggx import Ggx
from engine.brdf.half_angle import angle_of, place_of
from engine.brdf.half_angle_curve import NODES, HalfAngleCurve
from engine.brdf.layers import LAYERS, cut_for, factors
from engine.brdf.published import PUBLISHED
from engine.numerics.vec import vec

CUT = [
    m
    for m in [*LOBES, *PUBLISHED.values(), Ggx(diffuse=(0.1, 0.5, 0.9), specular=(0.9, 0.3, 0.01))]
    if LAYERS[table.INDEX[type(m)]] is not None
]


@njit
def _of_pairs(model, way, p, wi, wo, cut, whole):
    for i in range(wi.shape[0]):
        cut[i] = factors(way, p, vec(wi, i), vec(wo, i))
        whole[i] = table.evaluate(model, p, vec(wi, i), vec(wo, i))


def pairs(count: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Directions, half of the incident ones near the mirrored view."""
    random = np.random.default_rng(2)
    wi, wo = hemisphere(random, count), hemisphere(random, count)
    near = wo * [-1, -1, 1] + 0.2 * random.standard_normal((count, 3))
    wi[::2] = (near / np.linalg.norm(near, axis=1)[:, None])[::2]
    kept = (wi[:, 2] > 0.02) & (wo[:, 2] > 0.02)
    return wi[kept], wo[kept]


def both(
    material: Material, held: Material, count: int, basis: Basis, way: int = -1
) -> tuple[np.ndarray, ...]:
    """(the BRDF by its layers with quotients of `held`, the BRDF), (q, 3) each."""
    model, (wi, wo) = table.INDEX[type(material)], pairs()
    way = model if way < 0 else way
    layers = LAYERS[way]
    assert layers is not None
    cut, whole = np.zeros((len(wi), 6)), np.zeros((len(wi), 3))
    _of_pairs(model, way, held.row(), wi, wo, cut, np.zeros_like(whole))
    _of_pairs(model, way, material.row(), wi, wo, np.zeros_like(cut), whole)
    colours, curves = coefficients(layers, material.row(), count, basis)
    found = cut[:, 1 : 1 + layers.constants] @ colours
    for i, u in enumerate(cut[:, 0]):
        k, here, there = weights_at(u, count, basis == "tents")
        for layer in range(layers.curves):
            value = here * curves[layer, k]
            if there:
                value = value + there * curves[layer, k + 1]
            found[i] += cut[i, 4 + layer] * value
    weight = np.sqrt(wi[:, 2:])
    return weight * found, weight * whole


def off(found: np.ndarray, true: np.ndarray) -> float:
    return float(np.linalg.norm(found - true) / max(np.linalg.norm(true), 1e-30))


@pytest.mark.parametrize("material", CUT, ids=name_of)
def test_the_layers_are_the_brdf(material: Material) -> None:
    assert off(*both(material, material, 256, "tents")) < 0.01


def test_tents_leave_out_less_than_boxes() -> None:
    material = BlinnPhong(diffuse=(0, 0, 0), exponent=200)
    boxes, tents, few = (
        off(*both(material, material, count, basis))
        for count, basis in ((64, "boxes"), (64, "tents"), (16, "tents"))
    )
    assert boxes == pytest.approx(0.05, abs=0.01)
    assert tents < 0.002
    assert few < boxes


def test_one_hand_holds_all_colours_and_widths() -> None:
    """Quotients of one material serve another, but for what they are said to keep."""
    for material in CUT:
        layers = LAYERS[table.INDEX[type(material)]]
        other = next(m for m in CUT if type(m) is type(material))
        assert layers is not None
        if layers.covers(other.row(), material.row()):
            assert off(*both(material, other, 256, "tents")) < 0.01
    assert not LAYERS[table.INDEX[Ggx]].covers(  # type: ignore[union-attr]
        Ggx(roughness=0.2).row(), Ggx(roughness=0.3).row()
    )


BRUSHED = AshikhminShirley(exponent_u=20, exponent_v=100, specular=(0.6, 0.3, 0.1))


@pytest.mark.parametrize(
    ("edit", "kept"),
    [
        ({"exponent_u": 4, "exponent_v": 20}, "both in ratio"),
        ({"exponent_v": 3}, "n_u"),
        ({"exponent_v": 400}, "n_u"),
        ({"exponent_u": 300}, "n_v"),
    ],
)
def test_either_exponent_of_a_brushed_material_is_edited_alone(
    edit: dict[str, float], kept: str
) -> None:
    """Eq. 33 to 35: what stands of the lobe is in the quotient, and the rest is a curve."""
    model = table.INDEX[AshikhminShirley]
    now = BRUSHED.model_copy(update=edit)
    way = cut_for(model, BRUSHED.row(), now.row())
    ways = {"both in ratio": model, "n_u": len(table.MODULES), "n_v": len(table.MODULES) + 1}
    assert way == ways[kept]
    assert off(*both(now, BRUSHED, 256, "tents", way)) < 0.01
    layers = LAYERS[way]
    assert layers is not None
    found = shares(way, BRUSHED.row(), 64, "tents").albedo(
        *coefficients(layers, now.row(), 64, "tents")
    )
    np.testing.assert_allclose(found, hemispherical_albedo(model, now.row())[0], atol=6e-3)


def test_what_an_edit_of_a_brushed_material_is_taken_in_hand_with() -> None:
    model, before = table.INDEX[AshikhminShirley], BRUSHED.row()
    colour = BRUSHED.model_copy(update={"diffuse": (0.1, 0.2, 0.3)}).row()
    both_exponents = BRUSHED.model_copy(update={"exponent_u": 30, "exponent_v": 30}).row()
    across = len(table.MODULES)
    assert cut_for(model, before, colour) == model
    assert cut_for(model, before, colour, across) == across
    assert cut_for(model, before, both_exponents, across) == model
    assert (
        cut_for(table.INDEX[Ggx], Ggx(roughness=0.2).row(), Ggx(roughness=0.3).row())
        == (table.INDEX[Ggx])
    )


def test_64_tents_hold_every_curve_exactly() -> None:
    """Its nodes are nodes of the basis, and any curve is in hand with any other."""
    held = HalfAngleCurve()
    for seed in range(3):
        curve = tuple(2 * np.random.default_rng(seed).random(NODES))
        drawn = HalfAngleCurve(specular=(0.7, 0.2, 0.1), curve=curve)
        assert off(*both(drawn, held, 64, "tents")) < 1e-6
        layers = LAYERS[table.INDEX[HalfAngleCurve]]
        assert layers is not None
        assert layers.covers(held.row(), drawn.row())


@pytest.mark.parametrize("node", range(NODES))
def test_no_curve_makes_light_grow_from_bounce_to_bounce(node: int) -> None:
    """The albedo of later bounces is linear in the curve: one node alone is the worst."""
    model = table.INDEX[HalfAngleCurve]
    layers = LAYERS[model]
    assert layers is not None
    for diffuse, f0 in ((BLACK, 1.0), ((1.0, 1.0, 1.0), 0.04), ((1.0, 1.0, 1.0), 0.5)):
        row = spike(node, cover=2, diffuse=diffuse, specular=(f0,) * 3).row()
        found = shares(model, row, 64, "tents").albedo(*coefficients(layers, row, 64, "tents"))
        assert found.max() < 1.003


@pytest.mark.parametrize("material", CUT, ids=name_of)
def test_equivalent_albedo(material: Material) -> None:
    model = table.INDEX[type(material)]
    layers = LAYERS[model]
    assert layers is not None
    found = shares(model, material.row(), 64, "tents").albedo(
        *coefficients(layers, material.row(), 64, "tents")
    )
    np.testing.assert_allclose(found, hemispherical_albedo(model, material.row())[0], atol=6e-3)


def test_places_and_angles_go_both_ways() -> None:
    u = np.linspace(0, 1, 33)
    back = [place_of(np.cos(angle)) for angle in angle_of(u)]
    np.testing.assert_allclose(back, u, atol=2e-4)


@pytest.mark.parametrize("tents", [True, False])
def test_a_basis_sums_to_one(tents: bool) -> None:
    for u in (0.0, 0.3, 0.999999, 1.0):
        k, here, there = weights_at(u, 16, tents)
        assert here + there == pytest.approx(1)
        assert 0 <= k < (15 if tents else 16)
