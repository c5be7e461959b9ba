"""Metals and plastics to choose from reflect what the tables say."""

from __future__ import annotations

import numpy as np
import pytest
from brdf.materials import direction, model_and_row

from engine.brdf import albedo
from engine.brdf.published import METALS, PLASTICS


def reflected(material: object, degrees: float) -> np.ndarray:
    return albedo(*model_and_row(material), direction(degrees)[None])[0]  # type: ignore[arg-type]


@pytest.mark.parametrize("name", METALS)
def test_a_metal_reflects_its_f0_and_no_more_than_it_gets(name: str) -> None:
    metal = METALS[name]
    f0 = np.array(metal.model_dump()["specular"])
    # Its roughness takes some of it: light that its facets send into each other.
    np.testing.assert_allclose(reflected(metal, 0), f0, rtol=0.04)
    for degrees in (30.0, 60.0, 80.0, 89.0):
        assert reflected(metal, degrees).max() <= 1.001


def test_colours_of_metals() -> None:
    """Gold is yellow, copper red, silver all but white."""
    colours = {name: metal.model_dump()["specular"] for name, metal in METALS.items()}
    for name in ("gold", "copper"):
        red, green, blue = colours[name]
        assert red > 1.2 * green > 1.2 * blue
    assert min(colours["silver"]) > 0.9


@pytest.mark.parametrize("name", PLASTICS)
def test_a_plastic_has_a_colourless_gloss_over_its_colour(name: str) -> None:
    plastic = PLASTICS[name]
    base = np.array(plastic.model_dump()["diffuse"])
    np.testing.assert_allclose(reflected(plastic, 0), 0.04 + 0.96 * base, rtol=0.03)
    for degrees in (30.0, 60.0, 80.0):
        assert reflected(plastic, degrees).max() <= 1.001
