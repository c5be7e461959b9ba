"""Measured materials on the page: picked, chosen by their pictures, lit, opened, seen from afar."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import httpx
import numpy as np
import pytest
from playwright.sync_api import Browser, Page
from web.conftest import serve
from web.test_page import drag, settled

from engine.brdf.acquisition.csv_table import COLUMNS
from engine.methods.wavelet_brdf.levels import COLOURS
from engine.numerics.display import to_srgb8

pytestmark = pytest.mark.web

Visiting = Callable[..., AbstractContextManager[Any]]
SIZE = 96
BALL = (slice(36, 60), slice(36, 60))
ANGLES = (10, 40, 70)


def table(colour: tuple[float, float, float]) -> str:
    values = ",".join(map(str, colour))
    rows = [f"{i},0,{o},{p},{values}" for i in ANGLES for o in ANGLES for p in (0, 90, 180)]
    return "\n".join([",".join(COLUMNS), *rows])


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A service with a plastic ball under a lamp, and its product."""
    floor = {"shape": "rectangle", "size": [4, 4]}
    document = {
        "name": "ball",
        "camera": {"position": [0, 0.8, 2.2], "target": [0, 0, 0], "width": SIZE, "height": SIZE},
        "lights": [{"id": "key", "type": "point", "position": [0.3, 0.9, 0.9],
                    "intensity": [3, 3, 3]}],
        "materials": {
            "ball": {"type": "measured", "file": "plastic"},
            "floor": {"type": "diffuse", "diffuse": [0.5, 0.5, 0.5]},
        },
        "objects": [
            {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.5, "rings": 20},
             "material": "ball"},
            {"name": "floor", "mesh": floor, "material": "floor",
             "transform": {"translate": [0, -0.51, 0], "rotate_degrees": [-90, 0, 0]}},
        ],
    }  # fmt: skip
    path = tmp_path_factory.mktemp("scene") / "ball.json"
    path.write_text(json.dumps(document))
    (path.parent / "green felt.csv").write_text(table((0.02, 0.25, 0.02)))
    with serve(path, tmp_path_factory.mktemp("store"), {"gather_samples": 1024}) as address:
        with httpx.Client(base_url=address, timeout=300) as client:
            wanted = {"method": "wavelet_brdf"}
            job = client.post("/api/scenes/ball/precompute", json=wanted).json()
            while client.get(f"/api/jobs/{job['id']}").json()["status"] in ("queued", "running"):
                time.sleep(0.2)
            assert client.get(f"/api/jobs/{job['id']}").json()["status"] == "done"
        yield address


@pytest.fixture
def page(browser: Browser, lab: str, visiting: Visiting) -> Iterator[Page]:
    """A page with the method and its first picture."""
    with visiting(browser, lab) as visit:
        visit.page.locator("#methods [data-method=wavelet_brdf]").click()
        visit.page.wait_for_selector("canvas[data-method=wavelet_brdf]", timeout=60_000)
        settled(visit.page)
        yield visit.page


def choose(page: Page, name: str) -> None:
    """Click the picture of a material, and wait until it is in the hand."""
    page.locator(f".tile[data-name='{name}']").click()
    page.wait_for_selector(f".tile[data-name='{name}'][aria-pressed=true]", timeout=30_000)


def pick(page: Page, x: float, y: float) -> None:
    box = page.locator("#picture").bounding_box()
    assert box is not None
    with page.expect_response("**/pick?*"):
        page.mouse.click(box["x"] + x * box["width"], box["y"] + y * box["height"])
    page.wait_for_timeout(50)


def in_hand(page: Page) -> str:
    return page.locator("#editor-list .selected .name").inner_text()


def colour(image: np.ndarray) -> int:
    """The strongest channel of the ball."""
    return int(image[BALL].mean((0, 1)).argmax())


def test_a_material_is_picked_chosen_and_lit(page: Page) -> None:
    pick(page, 0.5, 0.95)
    assert in_hand(page) == "floor"
    pick(page, 0.5, 0.5)
    assert in_hand(page) == "ball"
    plastic = settled(page)
    assert colour(plastic) == 0
    page.wait_for_function("() => document.querySelector('.made').innerText.includes('tiles')")
    before = page.locator(".made").inner_text()
    assert " kB · " in before
    assert "% off" in before
    choose(page, "green felt.csv")
    felt = settled(page)
    assert colour(felt) == 1
    page.wait_for_function("(old) => document.querySelector('.made').innerText !== old", arg=before)
    # It is no other precompute, and the lamp still moves.
    assert page.locator("#progress").is_hidden()
    drag(page, "key", -120, 40)
    moved = settled(page)
    assert np.abs(moved[BALL] - felt[BALL]).mean() > 3
    assert colour(moved) == 1
    # The colour that multiplies it is edited as any other.
    page.get_by_label("Specular, exact").fill("20")
    page.keyboard.press("Enter")
    assert settled(page)[BALL].mean() < 0.7 * moved[BALL].mean()
    choose(page, "ward")
    assert np.ptp(settled(page)[BALL].mean((0, 1))) < 3
    page.get_by_role("button", name="Reset materials").click()
    assert colour(settled(page)) == 0


def test_a_file_is_opened_told_about_and_picked(page: Page, tmp_path: Path) -> None:
    pick(page, 0.5, 0.5)
    (tmp_path / "my blue.csv").write_text(table((0.02, 0.02, 0.25)))
    page.get_by_label("Measured material to open").set_input_files(tmp_path / "my blue.csv")
    page.wait_for_selector(".gallery .notices li", timeout=60_000)
    assert "'my blue'" in page.locator(".gallery .notices").inner_text()
    tile = page.locator(".tile", has_text="my blue")
    assert tile.get_attribute("aria-pressed") == "true"
    ball = tile.locator(".ball").evaluate("(n) => n.style.backgroundImage")
    assert ball.startswith('url("blob:')
    assert colour(settled(page)) == 2


def test_a_file_that_cannot_be_read_is_told(
    browser: Browser, lab: str, visiting: Visiting, tmp_path: Path
) -> None:
    with visiting(browser, lab) as visit:
        page: Page = visit.page
        page.locator("#methods [data-method=wavelet_brdf]").click()
        page.wait_for_selector("canvas[data-method=wavelet_brdf]", timeout=60_000)
        (tmp_path / "bad.csv").write_text(table((1, 1, 1))[:-3])
        page.get_by_label("Measured material to open").set_input_files(tmp_path / "bad.csv")
        page.wait_for_selector(".gallery .notices.bad li", timeout=60_000)
        told = page.locator(".gallery .notices").inner_text()
        assert "cells" in told
        assert "line 28" in told
        # The browser tells of it in its console by itself; nothing else went wrong.
        assert [error for error in visit.errors if "422" not in error] == []
        visit.errors.clear()


def test_levels_near_and_far(page: Page) -> None:
    usual = settled(page)
    page.get_by_label("Show the levels").check()
    near = settled(page)
    finest, coarsest = to_srgb8(COLOURS[[0, -1]].astype(np.float32))
    np.testing.assert_allclose(near[48, 48], finest, atol=1)
    np.testing.assert_array_equal(near[90, 48], 0)
    legend = page.locator("#legend i").evaluate("(n) => getComputedStyle(n).backgroundImage")
    ends = [f"rgb({', '.join(map(str, each))})" for each in (finest, coarsest)]
    assert all(end in legend for end in ends), legend
    # Nearer than that everything is coarser by a level.
    page.get_by_label("Coarser beyond").fill("-3")
    coarse = settled(page)
    assert np.abs(coarse[48, 48] - near[48, 48]).max() > 60
    page.get_by_role("button", name="Far").click()
    far = settled(page)
    assert (far.max(axis=2) > 0).sum() < 0.1 * (coarse.max(axis=2) > 0).sum()
    assert far[48, 48].argmax() == 0
    page.get_by_role("button", name="Near").click()
    assert (settled(page).max(axis=2) > 0).mean() > 0.5
    page.get_by_role("button", name="Reset view").click()
    page.get_by_label("Level by").select_option("finest")
    np.testing.assert_allclose(settled(page)[48, 48], finest, atol=1)
    page.get_by_label("Level by").select_option("distance")
    page.get_by_label("Show the levels").uncheck()
    page.get_by_label("Coarser beyond").fill("2.7")
    np.testing.assert_allclose(settled(page), usual, atol=2)


def relit(page: Page, dx: float) -> float:
    """How much the ball changes when the lamp is dragged."""
    before = settled(page)
    drag(page, "key", dx, 0)
    return float(np.abs(settled(page)[BALL] - before[BALL]).mean())


@pytest.mark.sweep
def test_models_are_relit_by_a_dragged_light(page: Page) -> None:
    pick(page, 0.5, 0.5)
    tiles = page.locator(".tile").evaluate_all("(all) => all.map((n) => n.dataset.name)")
    assert {"plastic", "ward", "poulin_fournier", "lafortune", "ggx"} <= set(tiles)
    for k, name in enumerate(("brushed", "threads", "lewis", "ward", "poulin_fournier")):
        choose(page, name)
        assert relit(page, (-90, 90)[k % 2]) > 2, name


@pytest.mark.data
def test_a_real_file_is_relit_by_a_dragged_light(page: Page, shared_data: Path) -> None:
    pick(page, 0.5, 0.5)
    page.get_by_label("Measured material to open").set_input_files(
        shared_data / "brdfs" / "garnet_red.brdf"
    )
    page.locator(".tile[title='garnet_red.brdf'][aria-pressed=true]").wait_for(timeout=60_000)
    assert relit(page, -90) > 0.5
