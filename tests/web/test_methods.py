"""Choosing the method on the page: the camera and the sky by hand, in a real browser."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page
from web.conftest import serve
from web.test_page import settled

pytestmark = pytest.mark.web

SIZE = 96


@pytest.fixture(scope="module")
def still_life(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A service with a glossy ball over a floor, in the studio."""
    floor = {"shape": "rectangle", "size": [4, 4], "segments": [24, 24]}
    document = {
        "name": "ball",
        "camera": {
            "position": [0.8, 1.2, 2.4],
            "target": [0, 0, 0],
            "width": SIZE,
            "height": SIZE,
        },
        "environment": {"map": "studio"},
        "lights": [],
        "materials": {
            "ball": {"type": "phong", "diffuse": [0.5, 0.1, 0.1], "specular": [0.3, 0.3, 0.3],
                     "exponent": 20},
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
    with serve(path, tmp_path_factory.mktemp("store"), {"gather_samples": 1024}) as address:
        yield address


def drag(page: Page, dx: int, dy: int, modifier: str | None = None) -> None:
    box = page.locator("#picture").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    if modifier:
        page.keyboard.down(modifier)
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(x + dx * k / 8, y + dy * k / 8)
        page.wait_for_timeout(20)
    page.mouse.up()
    if modifier:
        page.keyboard.up(modifier)


def test_the_camera_and_the_sky_by_hand(
    browser: Browser, still_life: str, visiting: Callable[..., AbstractContextManager[Any]]
) -> None:
    with visiting(browser, still_life) as visit:
        page: Page = visit.page
        page.get_by_role("radio", name="Camera and sky").click()
        page.wait_for_selector("canvas[data-method=glossy_prt]", timeout=120_000)
        assert page.locator("#lights-part").is_hidden()
        assert page.locator(".handle").count() == 0
        before = settled(page)
        drag(page, 120, 0)
        turned = settled(page)
        assert np.abs(turned - before).mean() > 2
        # Another camera is no other precompute: the method is there at once.
        assert page.locator("#canvas").get_attribute("data-method") == "glossy_prt"
        assert page.locator("#progress").is_hidden()
        drag(page, 150, 0, "Alt")
        lit = settled(page)
        assert np.abs(lit - turned).mean() > 1
        page.get_by_role("button", name="Reset view").click()
        page.get_by_role("button", name="Reset environment").click()
        np.testing.assert_allclose(settled(page), before, atol=1)
        page.get_by_role("radio", name="Lights").click()
        assert page.locator("#lights-part").is_visible()
