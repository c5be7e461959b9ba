"""Several lights at once: multipliers, locks, sizes by hand, presets, many of them, their keys."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page
from web.test_page import drag, pixels, settled

pytestmark = pytest.mark.web

Visiting = Callable[..., AbstractContextManager[Any]]
SHOWN = """() => Object.fromEntries([...document.querySelectorAll('#lights li')].map((row) =>
  [row.dataset.light, {
    on: row.querySelector('input').checked,
    selected: row.classList.contains('selected'),
    locked: row.querySelector('.lock').getAttribute('aria-pressed') === 'true',
    listed: !row.hidden,
  }]))"""
RECORD = """() => {
  const { send } = WebSocket.prototype;
  WebSocket.prototype.send = function (text) {
    const message = JSON.parse(text);
    if (message.type === 'edit') window.sent = message.edits;
    send.call(this, text);
  };
}"""


def shown(page: Page, what: str) -> list[str]:
    """Ids of the lights that are on, selected, locked or listed."""
    return [name for name, row in page.evaluate(SHOWN).items() if row[what]]


def click(page: Page, name: str, *keys: Any) -> None:
    page.locator(f"#lights [data-light={name}] .name").click(modifiers=list(keys))


def sent(page: Page) -> dict[str, Any]:
    """Lights of the last edit that was sent, by id."""
    page.evaluate("new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
    return {light["id"]: light for light in page.evaluate("window.sent.lights ?? []")}


def typed(page: Page, label: str, value: str) -> None:
    page.get_by_label(label, exact=True).fill(value)
    page.keyboard.press("Enter")
    page.get_by_label(label, exact=True).blur()


def key_of(page: Page, *keys: str) -> None:
    page.evaluate("document.activeElement.blur()")
    for key in keys:
        page.keyboard.press(key)


def test_several_lights_are_edited_as_one(visit: Any) -> None:
    page: Page = visit.page
    page.evaluate(RECORD)
    click(page, "key")
    key_of(page, "Control+d")
    assert shown(page, "selected") == ["key-2"]
    click(page, "key", "Control")
    assert shown(page, "selected") == ["key", "key-2"]
    # What they have in common is shown, what they have not is not.
    x = page.get_by_label("Position x")
    assert (x.input_value(), x.get_attribute("placeholder")) == ("", "mixed")
    assert page.get_by_label("Cone", exact=True).input_value() == "18"

    # Typed, all have the same; pulled in the picture, all go along.
    typed(page, "Cone", "25")
    before = sent(page)
    assert {light["cone_degrees"] for light in before.values()} == {25}
    drag(page, "key", 40, 20)
    after = sent(page)
    shifts = [np.subtract(after[name]["position"], before[name]["position"]) for name in after]
    np.testing.assert_allclose(shifts[0], shifts[1], atol=1e-12)
    assert np.linalg.norm(shifts[0]) > 0.01
    # The rim of the cone is a handle, and changes both by the same factor.
    drag(page, "key", 40, 0, "cone_degrees")
    cones = [light["cone_degrees"] for light in sent(page).values()]
    assert cones[0] == pytest.approx(cones[1])
    assert cones[0] > 26

    # A multiplier keeps the intensity, and is what edits have in it; the slider is relative.
    click(page, "key-2")
    typed(page, "Multiplier, exact", "4")
    assert sent(page)["key-2"]["intensity"] == pytest.approx([1.2, 1.2, 1.28])
    assert page.get_by_label("Intensity, exact").input_value() == "0.32"
    click(page, "key", "Control")
    factor = page.get_by_label("Multiplier, exact")
    assert factor.get_attribute("placeholder") == "mixed"
    page.get_by_label("Multiplier", exact=True).press("ArrowRight")
    strengths = {name: light["intensity"][2] for name, light in sent(page).items()}
    assert strengths["key-2"] == pytest.approx(4 * strengths["key"])
    assert strengths["key"] > 0.32

    # On the handles in the picture too, with a key held.
    key_of(page, "Escape")
    assert shown(page, "selected") == []
    for name in ("key", "ceiling"):
        page.locator(f".handle[data-light={name}].source").click(modifiers=["Shift"])
    assert shown(page, "selected") == ["ceiling", "key"]
    page.locator(".handle[data-light=key].source").click()
    assert shown(page, "selected") == ["key"]
    key_of(page, "Control+a")
    assert len(shown(page, "selected")) == 3
    key_of(page, *["Control+z"] * 12)
    assert shown(page, "on") == ["ceiling", "key"]


def test_locks_keys_and_the_link(browser: Browser, address: str, visiting: Visiting) -> None:
    with visiting(browser, address) as visit:
        page: Page = visit.page
        page.evaluate(RECORD)
        click(page, "key")
        typed(page, "Multiplier, exact", "0.3")
        key_of(page, "l")
        assert shown(page, "locked") == ["key"]
        assert page.get_by_label("Position x").is_disabled()
        before = sent(page)
        drag(page, "key", 60, 0)
        page.keyboard.press("ArrowLeft")
        key_of(page, "Delete", "ArrowLeft")
        assert sent(page) == before
        # It can be switched, and copied; the copy is free. Those of the scene are turned off.
        key_of(page, "h", "Control+d", "h")
        assert shown(page, "on") == ["ceiling", "key-2"]
        key_of(page, "ArrowRight")
        moved = sent(page)["key-2"]["position"]
        key_of(page, "s")
        assert shown(page, "on") == ["key-2"]
        key_of(page, "s")
        click(page, "ceiling")
        key_of(page, "Delete")
        assert shown(page, "on") == ["key-2"]
        page.keyboard.press("?")
        assert page.locator("#keys").is_visible()
        page.keyboard.press("Escape")
        page.get_by_role("button", name="Copy link").click()
        page.wait_for_function("() => location.hash.length > 10")
        link, picture = page.url, settled(page)
    with visiting(browser, link) as visit:
        page = visit.page
        np.testing.assert_array_equal(settled(page), picture)
        assert shown(page, "locked") == ["key"]
        click(page, "key-2")
        assert page.get_by_label("Multiplier, exact").input_value() == "0.3"
        assert page.get_by_label("Intensity, exact").input_value() == "0.32"
        x = float(page.get_by_label("Position x").input_value())
        assert x == pytest.approx(moved[0], abs=1e-3)


def test_more_than_sixty_lights_and_presets(visit: Any) -> None:
    page: Page = visit.page
    dark = pixels(page)
    page.select_option("#add", "preset three")
    assert sorted(shown(page, "selected")) == ["fill-1", "key-1", "rim-1"]
    assert np.abs(settled(page) - dark).mean() > 5
    for _ in range(8):
        page.select_option("#add", "preset ring")
    assert len(page.evaluate(SHOWN)) == 69
    list_ = page.locator("#lights").bounding_box()
    assert list_ is not None
    assert list_["height"] < 300
    filter_ = page.get_by_label("Filter lights by name")
    filter_.fill("ring-6")
    assert shown(page, "listed") == ["ring-6", *[f"ring-{k}" for k in range(60, 65)]]
    key_of(page, "Control+a")
    assert len(shown(page, "selected")) == 6
    # Only one row is reached by Tab; arrows lead from there, with Shift over several.
    assert page.locator("#lights .name[tabindex='0']").count() == 1
    page.locator("#lights .name[tabindex='0']").focus()
    page.keyboard.press("Home")
    page.keyboard.press("Shift+ArrowDown")
    assert shown(page, "selected") == ["ring-6", "ring-60"]
    page.keyboard.press("Delete")
    filter_.fill("")
    assert len(page.evaluate(SHOWN)) == 67
    page.locator("#reset").click()
    assert shown(page, "on") == ["ceiling", "key"]


def test_the_method_follows_from_what_is_taken(visit: Any) -> None:
    """And a step back brings back the method before."""
    page: Page = visit.page

    def method() -> str | None:
        return page.locator("#methods [aria-checked=true]").get_attribute("data-method")

    told = page.locator("#notes-first")
    assert method() == "direct_to_indirect"
    page.get_by_role("button", name="Got it").click()
    page.get_by_label("Diffuse, exact").fill("10")
    page.keyboard.press("Enter")
    assert method() == "brdf_editing"
    drag(page, "key", 20, 0)
    assert method() == "brdf_editing"
    page.get_by_label("Environment map").select_option(label="Noon")
    assert method() == "direct_to_indirect"
    assert "changed materials" in told.inner_text()
    for name in ("brdf_editing", "brdf_editing", "direct_to_indirect"):
        key_of(page, "Control+z")
        assert method() == name
    assert "Not shown" not in told.inner_text()
    # Without a lamp the method whose camera is free carries all the light that there is.
    page.get_by_label("Environment map").select_option(label="Studio")
    for name in ("ceiling", "key"):
        page.get_by_label(f"{name} on").uncheck()
    box = page.locator("#picture").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + 300, box["y"] + 300)
    page.mouse.down(button="right")
    page.mouse.move(box["x"] + 340, box["y"] + 300, steps=4)
    page.mouse.up(button="right")
    assert method() == "glossy_prt"
    whole = page.evaluate("() => document.getElementById('keep-link').click() ?? null")
    assert whole is None
    page.wait_for_function("() => location.hash.length > 10")
    kept = page.evaluate("JSON.parse(decodeURIComponent(location.hash.slice(1)))")
    # What it does not show is kept.
    assert [light["enabled"] for light in kept["others"]["lights"]] == [False, False]
    assert json.dumps(kept["edits"]["environment"]["map"]) == '"studio"'
    page.get_by_label("key on").check()
    assert method() == "direct_to_indirect"
