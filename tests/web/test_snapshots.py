"""Snapshots: taken, gone back to, laid over the picture and wiped, removed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page
from web.test_page import drag, light, settled

pytestmark = pytest.mark.web

SHOWN = """async () => {
  const box = document.getElementById('picture').getBoundingClientRect();
  const over = document.getElementById('beside');
  return {
    hidden: over.hidden, clip: getComputedStyle(over).clipPath,
    same: Math.abs(over.getBoundingClientRect().width - box.width) < 1,
  };
}"""


def test_a_snapshot_is_gone_back_to_and_compared_with(visit: Any) -> None:
    page: Page = visit.page
    before = settled(page)
    take = page.get_by_role("button", name="Take")
    take.click()
    page.wait_for_selector("#snapshots li")
    light(page, "key")
    drag(page, "key", 120, 10)
    page.get_by_label("ceiling on").uncheck()
    after = settled(page)
    assert np.abs(after - before).mean() > 2
    take.click()
    assert page.locator("#snapshots li").count() == 2

    # Wiped over the live picture, by the mouse and by keys.
    page.get_by_role("button", name="Compare with snapshot 1").click()
    shown = page.evaluate(SHOWN)
    assert not shown["hidden"]
    assert shown["same"]
    assert shown["clip"] == "inset(0px 50% 0px 0px)"
    wipe = page.get_by_label("Wipe")
    wipe.focus()
    page.keyboard.press("End")
    assert (
        page.evaluate(SHOWN)["clip"].startswith("inset(0px 0% 0px 0px)")
        or page.evaluate(SHOWN)["clip"] == "inset(0px)"
    )
    np.testing.assert_array_equal(settled(page), after)
    # Side by side, as large as each other and apart.
    page.get_by_label("Side by side").check()
    assert page.evaluate(SHOWN)["hidden"]
    apart, live = (page.locator(each).bounding_box() for each in ("#apart", "#picture"))
    assert apart is not None
    assert live is not None
    assert apart["width"] == pytest.approx(live["width"], abs=1)
    assert apart["x"] + apart["width"] <= live["x"]
    page.get_by_role("button", name="Compare with snapshot 1").click()
    assert page.locator("#apart").is_hidden()

    # Back, and forth again: each is a step that can be undone.
    page.get_by_role("button", name="Go back to snapshot 1").click()
    np.testing.assert_array_equal(settled(page), before)
    page.get_by_role("button", name="Go back to snapshot 2").click()
    np.testing.assert_array_equal(settled(page), after)

    page.get_by_role("button", name="Remove snapshot 1").click()
    assert page.locator("#snapshots li").count() == 1
    assert page.evaluate("document.activeElement.id") == "snapshot-take"


def test_snapshots_are_those_of_their_scene(visit: Any) -> None:
    page: Page = visit.page
    settled(page)
    page.get_by_role("button", name="Take").click()
    page.wait_for_selector("#snapshots li")
    page.locator("#scenes button").nth(1).click()
    page.wait_for_function("() => !document.title.startsWith('box')")
    assert page.locator("#snapshots li").count() == 0
