"""The paper's figures: their skies, their numbers, and what is drawn of them."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from PIL import Image

from engine.light.environment import environment_table
from engine.light.environment import radiance as radiance_from
from engine.measure import contact_sheet
from engine.measure.contact_sheet import Row, Sheet, Tile, difference
from engine.measure.figures import FIGURES, LAMP, SUN, Shoot, spot_sky
from engine.measure.stage import ball
from engine.store import Store

FIXED = {"light_texels": 16, "visibility_texels": 16, "brdf_texels": 16}


@pytest.fixture(scope="module")
def shoot(tmp_path_factory: pytest.TempPathFactory) -> Shoot:
    store = Store(tmp_path_factory.mktemp("store"))
    return Shoot(ball(10), (24, 24), cuts=10, fixed=FIXED, reference_error=0.1, store=store)


@pytest.mark.parametrize("sky", [SUN, LAMP], ids=["sun", "lamp"])
def test_a_spot_in_the_sky(sky: tuple) -> None:
    """All of it together is as bright as an even sky of its colour; it is where it ought to be."""
    direction, degrees, colour, rest = sky
    made = spot_sky(*sky)
    height = len(made.radiance)
    edges = np.cos(np.linspace(0, np.pi, height + 1))
    mean = np.einsum("ijc,i->c", made.radiance, edges[:-1] - edges[1:]) / (4 * height)
    assert mean == pytest.approx(colour, rel=1e-3)
    axis = np.array(direction) / np.linalg.norm(direction)
    table = environment_table(made)
    there, elsewhere = radiance_from(table, tuple(axis)), radiance_from(table, tuple(-axis))
    share = (1 - np.cos(np.radians(degrees))) / 2
    expected = rest + (1 - rest) / share
    assert there == pytest.approx(expected * np.array(colour), rel=0.1)
    assert elsewhere == pytest.approx(rest * np.array(colour), rel=1e-5)


@pytest.mark.sweep
def test_interreflections(shoot: Shoot) -> None:
    """A bounce brings the picture closer to all light, on matt and on glossy surfaces."""
    sheet = FIGURES[6](shoot)
    pictures = sheet.document["pictures"]
    assert [p["material"] for p in pictures] == ["diffuse"] * 3 + ["red Phong"] * 3
    for three in (pictures[:3], pictures[3:]):
        assert [p["bounces"] for p in three] == [0, 1, 2]
        assert three[0]["of_all"] > three[1]["of_all"] >= three[2]["of_all"] - 0.005
    assert pictures[0]["relative_l2"] < 0.05
    assert len(sheet.rows) == 4
    assert "off all light" in sheet.rows[1].tiles[0].caption  # type: ignore[union-attr]


@pytest.mark.sweep
def test_terms(shoot: Shoot) -> None:
    found = FIGURES[8](shoot).document["pictures"]
    off = {p["terms"]: p["relative_l2"] for p in found}
    assert list(off) == [1, 2, 4, 8, 16]
    assert off[1] > off[4] > off[16]
    assert off[16] < 0.6 * off[1]
    assert abs(found[-1]["light"] - 1) < 0.15


@pytest.mark.sweep
def test_wavelets(shoot: Shoot) -> None:
    """At the paper's cube map and on a fine floor: a coarse one hides what wavelets do to a shadow,
    as it is itself farther off.
    """
    fine = {"brdf_texels": 16, "light_texels": 64, "visibility_texels": 64}
    found = FIGURES[10](replace(shoot, cuts=48, fixed=fine)).document["pictures"]
    off = {p["coefficients"]: p["floor"] for p in found}
    assert list(off) == [32, 64, 128, 256, 512]
    assert off[32] > off[64] > off[128] > 0.9 * off[512]
    assert off[32] > 1.4 * off[512]
    assert [p["kept"] for p in found] == [n / 24576 for n in off]


@pytest.mark.sweep
def test_gathering(shoot: Shoot) -> None:
    sheet = FIGURES[11](shoot)
    off = {p["gather_texels"]: p["relative_l2"] for p in sheet.document["pictures"]}
    assert list(off) == [8, 16, 32, 64]
    assert off[8] > off[64]
    assert off[64] < 0.15
    # The finest is what the others are compared with: it is white all over.
    finest = sheet.rows[1].tiles[3]
    assert finest is not None
    assert np.ptp(finest.image) == pytest.approx(np.ptp(finest.image[0, 0]), abs=1e-12)


def test_colours_of_a_difference() -> None:
    reference = np.full((2, 3, 3), 0.5, np.float32)
    image = reference.copy()
    image[0, 0] += 0.05
    image[0, 1] -= 0.05
    image[1] += 9.0
    mask = np.array([[True] * 3, [False] * 3])
    shown = difference(image, reference, mask, 0.2, "").image
    colours = matplotlib.colormaps["RdBu_r"]
    assert shown[0, 0] == pytest.approx(colours(0.75)[:3], abs=0.02)
    assert shown[0, 1] == pytest.approx(colours(0.25)[:3], abs=0.02)
    assert shown[0, 2] == pytest.approx(colours(0.5)[:3], abs=0.02)
    assert shown[1] == pytest.approx(np.tile(colours(1.0)[:3], (3, 1)), abs=1e-6)
    red, _, blue = shown[0, 0]
    assert red > blue


def test_a_sheet_on_paper(shoot: Shoot, tmp_path: Path) -> None:
    """Every picture is there, in the colours that it has, and so are the numbers."""
    red, green = np.zeros((6, 8, 3)), np.zeros((6, 8, 3))
    red[..., 0] = green[..., 1] = 1
    rows = [Row("one", [Tile(red, "red"), None]), Row("two", [Tile(red, "red"), Tile(green, "g")])]
    sheet = Sheet("title", "caption", rows, shoot.document(8, [{"terms": 1}]))
    image, numbers = contact_sheet.write(sheet, tmp_path, "sheet")
    document = json.loads(numbers.read_text())
    assert document["pictures"] == [{"terms": 1}]
    assert document["settings"]["light_texels"] == 16
    with Image.open(image) as opened:
        pixels = np.asarray(opened.convert("RGB")).astype(int)
    red_area = (pixels == (255, 0, 0)).all(axis=2).sum()
    green_area = (pixels == (0, 255, 0)).all(axis=2).sum()
    assert green_area > 10_000
    assert red_area == pytest.approx(2 * green_area, rel=0.05)
