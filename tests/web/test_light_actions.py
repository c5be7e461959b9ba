"""A light copied, alone, and of another temperature."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page
from web.test_page import light, settled

pytestmark = pytest.mark.web

SWITCHES = """() => Object.fromEntries(
  [...document.querySelectorAll('#lights li')].map((row) =>
    [row.querySelector('.name').textContent, row.querySelector('input').checked]))"""


def test_a_copy_stands_beside_and_shines_as_much(visit: Any) -> None:
    page: Page = visit.page
    page.get_by_label("ceiling on").uncheck()
    place = light(page, "key")
    one = settled(page)
    page.get_by_role("button", name="Duplicate").click()
    two = settled(page)
    assert page.evaluate(SWITCHES) == {"ceiling": False, "key": True, "key-2": True}
    copied = light(page, "key-2")
    assert copied["x"] > place["x"] + 0.01
    assert (copied["y"], copied["z"]) == (place["y"], place["z"])
    assert two.mean() > 1.2 * one.mean()
    page.get_by_role("button", name="Duplicate").click()
    assert "key-3" in page.evaluate(SWITCHES)
    page.get_by_role("button", name="Remove", exact=True).click()
    assert "key-3" not in page.evaluate(SWITCHES)


def test_solo_and_back(visit: Any) -> None:
    page: Page = visit.page
    before = settled(page)
    solo = page.get_by_role("button", name="Solo")
    light(page, "key")
    solo.click()
    assert page.evaluate(SWITCHES) == {"ceiling": False, "key": True}
    assert solo.get_attribute("aria-pressed") == "true"
    # From one to the other, and back to what was on at first.
    light_list = page.locator(".lights button.name")
    light_list.filter(has_text="ceiling").click()
    solo.click()
    assert page.evaluate(SWITCHES) == {"ceiling": True, "key": False}
    solo.click()
    assert page.evaluate(SWITCHES) == {"ceiling": True, "key": True}
    np.testing.assert_array_equal(settled(page), before)


def test_a_warm_light_is_redder_and_as_strong(visit: Any) -> None:
    page: Page = visit.page
    light(page, "key")
    page.get_by_role("button", name="Solo").click()
    strength = page.get_by_label("Intensity, exact").input_value()
    ratio = {}
    for kelvin in ("2000", "6500", "12000"):
        exact = page.get_by_label("Temperature, exact")
        exact.fill(kelvin)
        exact.press("Enter")
        exact.blur()
        assert float(exact.input_value()) == pytest.approx(float(kelvin), rel=0.02)
        assert page.get_by_label("Intensity, exact").input_value() == strength
        shown = settled(page).mean((0, 1))
        ratio[kelvin] = shown[0] / shown[2]
    assert ratio["2000"] > 2 * ratio["6500"] > 2.2 * ratio["12000"]


def test_black_bodies_have_the_colours_that_they_have(visit: Any) -> None:
    """Against chromaticities of the CIE: illuminant A is 2,856 K, and 6,504 K is near D65."""
    found = visit.page.evaluate(
        """async () => {
          const { ofTemperature, temperatureOf } = await import('./colour.js');
          return {
            a: ofTemperature(2856), day: ofTemperature(6504),
            round: [1800, 2700, 4000, 6500, 10000].map((k) => temperatureOf(ofTemperature(k)) / k),
            none: [temperatureOf([0, 1, 0]), temperatureOf([0, 0, 0])],
          };
        }"""
    )
    # A: x 0.44757, y 0.40745 in linear sRGB, its largest channel 1.
    x, y = 0.44757, 0.40745
    a = np.array(
        [[3.2404542, -1.5371385, -0.4985314], [-0.969266, 1.8760108, 0.041556],
         [0.0556434, -0.2040259, 1.0572252]]
    ) @ [x / y, 1, (1 - x - y) / y]  # fmt: skip
    np.testing.assert_allclose(found["a"], a / a.max(), atol=0.01)
    np.testing.assert_allclose(found["day"], 1, atol=0.06)
    np.testing.assert_allclose(found["round"], 1, atol=0.03)
    assert found["none"] == [None, None]
