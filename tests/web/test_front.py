"""Speed and accuracy on the page: the chart, the error budget, and what the reference shows."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Locator, Page
from web.conftest import serve
from web.test_page import drag, pixels, settled

from engine.measure import front as module
from engine.measure.front import front
from engine.measure.pilots import Cost
from engine.scene.builtin import cornell_box
from engine.scene.open import open_scene
from engine.store import Store
from server.precompute import settings_of

pytestmark = pytest.mark.web

METHOD, SIZE = "direct_to_indirect", 48
SETTINGS = {"gather_samples": 1024}
WARN = """async () => {
  const { Status } = await import("./status.js");
  const status = new Status((id) => document.getElementById(id), () => {});
  const warnings = [["large", 0.1], ["small", 0.02], ["of no size", 0]]
    .map(([message, size]) => ({ code: "", message, size }));
  const header = { method: "direct", timings: { total: 1 }, warnings, error: null, job: null };
  status.setBudget(0.05);
  status.frame(header, null);
  const told = [...document.querySelectorAll("#status-warnings li")].map((li) => li.textContent);
  status.frame({ ...header, warnings: [] }, null);
  return told;
}"""


class Pilots:
    """Made-up ones: the more wavelets the less error, and the longer a frame."""

    def __init__(self, *_: Any) -> None:
        pass

    def run(self, method: str, settings: Any) -> Cost:
        count = settings.coefficients
        return Cost(0.9 / count, 1e-4 * count, 1e4 * count, 0.1 * count)

    def whole(self, method: str, settings: Any, small: Cost) -> Cost:
        return small


@pytest.fixture(scope="module")
def charted(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A service with a tiny box whose chart has been measured, by made-up pilots."""
    document = cornell_box.document()
    document["camera"] |= {"width": SIZE, "height": SIZE}
    path, store = tmp_path_factory.mktemp("scene") / "box.json", tmp_path_factory.mktemp("store")
    path.write_text(json.dumps(document))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(module, "Pilots", Pilots)
        front(open_scene(path), METHOD, settings_of(METHOD, SETTINGS), Store(store))
    with serve(path, store, SETTINGS) as address:
        yield address


Visiting = Callable[..., AbstractContextManager[Any]]


def said(text: Locator) -> str:
    return text.inner_text().replace("\xa0", " ")


def slide(page: Page, part: float) -> None:
    """Click on the error budget's slider, from 0 at its left to 1."""
    page.locator("#budget").scroll_into_view_if_needed()
    box = page.locator("#budget").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + 8 + part * (box["width"] - 16), box["y"] + box["height"] / 2)


def test_what_the_reference_shows(browser: Browser, charted: str, visiting: Visiting) -> None:
    with visiting(browser, charted) as visit:
        page: Page = visit.page
        settled(page)
        page.get_by_role("button", name="What would the reference show?").click()
        page.wait_for_selector("#reference-progress:not([hidden])")
        page.wait_for_selector("#reference-pictures:not([hidden])", timeout=90_000)
        told = said(page.locator("#reference-told"))
        assert "% off (relative L2, edges and lamps left out)" in told
        assert "the reference's own noise is" in told
        page.wait_for_function(
            "() => [...document.querySelectorAll('#reference-pictures img')]"
            f".every((image) => image.naturalWidth === {SIZE})"
        )
        difference = page.locator("#reference-pictures button", has_text="Difference")
        difference.click()
        assert page.locator("#reference-over").is_visible()
        assert page.locator("#reference-again").is_hidden()
        drag(page, "key", 30, 0)
        assert page.locator("#reference-over").is_hidden()
        assert page.inner_text("#reference-told").startswith("Before the last change: ")
        assert page.locator("#reference-again").is_visible()
        page.keyboard.press("Escape")
        assert page.locator("#reference").is_hidden()


def test_the_budget_picks_settings_and_frames_take_them(
    browser: Browser, charted: str, visiting: Visiting
) -> None:
    with visiting(browser, charted) as visit:
        page: Page = visit.page
        settled(page)
        told, use = page.locator("#budget-told"), page.locator("#budget-use")
        assert page.locator("#front-chart circle").count() == 7
        assert said(page.locator("#budget-value")) == "1 %"
        assert said(told) == "0.9 %, 10 ms, 1 MB, 10 s of precompute"
        assert use.is_disabled()
        assert page.evaluate(WARN) == ["large", "of no size"]
        # Every point says what it is, and the live one is there.
        page.locator("#front-chart circle").nth(1).hover()
        assert "coefficients 12" in page.inner_text("#front-chart .tip")
        assert page.locator("#front-chart .live").get_attribute("d")

        slide(page, 0.0)
        assert said(told) == "0.45 %, 20 ms, 2 MB, 20 s of precompute"
        slide(page, 1.0)
        assert said(page.locator("#budget-value")) == "50 %"
        assert said(told) == "7.5 %, 1.2 ms, 0.12 MB, 1.2 s of precompute"
        before = pixels(page)
        use.click()
        page.wait_for_function(
            "() => document.getElementById('budget-use').textContent === 'In use'", timeout=90_000
        )
        page.wait_for_function("() => document.getElementById('canvas').dataset.state === 'final'")
        after = settled(page)
        assert 0.2 < np.abs(after - before).mean() < 20
        # What was never measured is, when asked for, until somebody stops it.
        page.locator("[data-method=brdf_editing]").click()
        page.locator("#front-measure").click()
        page.locator("#front-measuring").get_by_role("button", name="Cancel").click()
        page.wait_for_selector("#front-measure:not([hidden])")
        assert page.locator("#front-measuring").is_hidden()
        assert page.locator("#front-chart").is_hidden()
