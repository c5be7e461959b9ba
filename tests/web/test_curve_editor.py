"""A curve of points under the hand: by mouse and by keys, in a real browser."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page
from web.conftest import serve
from web.test_methods import WATCH
from web.test_page import settled

from engine.brdf.as_curve import as_curve
from engine.brdf.blinn_phong import BlinnPhong
from engine.brdf.half_angle_curve import ANGLES_DEGREES, NODES

pytestmark = pytest.mark.web

SIZE = 64
LOBE = {"diffuse": [0.1, 0.1, 0.1], "specular": [0.3, 0.3, 0.3], "exponent": 30}
SETTINGS = {"gather_samples": 256, "view_rays": 64, "bounces": 1}


@pytest.fixture(scope="module")
def ball(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A service with a glossy ball under a point light."""
    document = {
        "name": "ball",
        "camera": {"position": [0, 0.4, 2], "target": [0, 0, 0], "width": SIZE, "height": SIZE},
        "lights": [{"id": "key", "type": "point", "position": [0.5, 1, 2],
                    "intensity": [9, 9, 9]}],
        "materials": {"ball": {"type": "blinn_phong", **LOBE}},
        "objects": [{"name": "ball", "mesh": {"shape": "sphere", "radius": 0.6},
                     "material": "ball"}],
    }  # fmt: skip
    path = tmp_path_factory.mktemp("scene") / "ball.json"
    path.write_text(json.dumps(document))
    with serve(path, tmp_path_factory.mktemp("store"), SETTINGS) as address:
        yield address


def curve(page: Page) -> list[float]:
    """The curve of the last edit, once it is sent and drawn."""
    settled(page)
    found: list[float] = page.evaluate("window.sent.edits.materials.ball.curve")
    return found


def point(page: Page, node: int) -> Locator:
    return page.get_by_role("slider", name="Curve at").nth(node)


def middle(point: Locator) -> tuple[float, float]:
    box = point.bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


def test_a_lobe_is_bent_by_hand(
    browser: Browser, ball: str, visiting: Callable[..., AbstractContextManager[Any]]
) -> None:
    with visiting(browser, ball) as visit:
        page: Page = visit.page
        page.evaluate(WATCH)
        page.locator("button[data-method=brdf_editing]").click()
        page.wait_for_selector("canvas[data-method=brdf_editing]", timeout=180_000)
        page.locator("#editor select").select_option("half_angle_curve")
        page.wait_for_selector(".curve circle")
        start = settled(page)
        # It starts from the lobe that was there.
        given = as_curve(BlinnPhong(**LOBE)).curve
        assert curve(page) == list(given)
        assert page.locator(".curve circle").count() == NODES
        assert point(page, 9).get_attribute("aria-label") == f"Curve at {ANGLES_DEGREES[9]:.2f}°"
        assert "covers 100 %" in page.locator(".curve .told").inner_text()

        # Down by the mouse: the highlight goes, all other points stay.
        page.locator(".curve").scroll_into_view_if_needed()
        point(page, 3).scroll_into_view_if_needed()
        x, y = middle(point(page, 3))
        page.mouse.move(x, y)
        page.mouse.down()
        for k in range(1, 6):
            page.mouse.move(x, y + 12 * k)
        page.mouse.up()
        bent = curve(page)
        assert 0 < bent[3] < 0.3 * given[3]
        assert bent[:3] + bent[4:] == [*given[:3], *given[4:]]
        assert page.evaluate("document.activeElement.getAttribute('aria-valuenow')") == str(bent[3])
        dimmed = settled(page)
        assert np.abs(dimmed - start).max() > 8

        # By keys: to the neighbour, then up and down.
        page.keyboard.press("ArrowRight")
        page.keyboard.press("ArrowUp")
        assert curve(page)[4] > given[4]
        page.keyboard.press("ArrowDown")
        np.testing.assert_allclose(curve(page)[4], given[4], rtol=2e-3)
        page.keyboard.press("ArrowLeft")
        for _ in range(10):
            page.keyboard.press("PageDown")
        assert curve(page)[3] == 0

        # More than there is of the surface is scaled, and said.
        page.keyboard.press("End")
        page.keyboard.press("ArrowLeft")
        page.keyboard.press("ArrowLeft")
        for _ in range(9):
            page.keyboard.press("PageUp")
        assert "times too much" in page.locator(".curve .told").inner_text()
        assert np.abs(settled(page) - start).max() > 100
        assert page.locator("#problem").is_hidden()
        # Or refused, and the picture stays.
        page.get_by_label("Energy").select_option("refuse")
        page.wait_for_selector("#problem:visible")
        assert "would reflect more than they receive" in page.locator("#problem").inner_text()
        page.get_by_label("Energy").select_option("scale")
        page.wait_for_selector("#problem", state="hidden")
        page.get_by_role("button", name="Reset", exact=True).last.click()
        assert page.locator(".curve").count() == 0
