"""The environment's panel, in a real browser: maps, turning, brightness, a sun and its sky."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page
from web.test_page import pixels, settled

from engine.images import encode_exr

pytestmark = pytest.mark.web


def choose(page: Page, kind: str) -> None:
    page.get_by_label("Environment map").select_option(label=kind)


def slide(page: Page, label: str, to: float) -> None:
    """Move a slider as a hand does: input events on the way, a change at its end."""
    page.get_by_label(label, exact=True).evaluate(
        """async (slider, to) => {
          const from = slider.valueAsNumber;
          slider.focus();
          for (let k = 1; k <= 8; k += 1) {
            slider.value = from + (to - from) * k / 8;
            slider.dispatchEvent(new Event('input', { bubbles: true }));
            await new Promise((done) => setTimeout(done, 20));
          }
          slider.dispatchEvent(new Event('change', { bubbles: true }));
          slider.blur();
        }""",
        to,
    )


def exact(page: Page, label: str) -> float:
    return float(page.get_by_label(f"{label}, exact").input_value())


def test_maps_rotation_and_brightness(visit: Any) -> None:
    page: Page = visit.page
    bare = settled(page)
    assert page.get_by_label("Environment map").input_value() == "none"
    assert page.locator("#environment .field").count() == 0
    choose(page, "Studio")
    studio = settled(page)
    # The box is open towards the camera only: what is behind the camera shines into it.
    assert studio.mean() > bare.mean() + 2
    slide(page, "Rotation", 120)
    assert exact(page, "Rotation") == 120
    turned = settled(page)
    assert np.abs(turned - studio).mean() > 0.5
    slide(page, "Brightness", 0.6)
    assert exact(page, "Brightness") == pytest.approx(10**0.6, rel=1e-3)
    assert settled(page).mean() > turned.mean() + 5
    page.get_by_role("button", name="Reset environment").click()
    np.testing.assert_allclose(settled(page), bare, atol=1)
    assert page.get_by_role("button", name="Reset environment").is_disabled()


def test_small_frames_come_while_the_slider_moves(visit: Any) -> None:
    page: Page = visit.page
    settled(page)
    choose(page, "Studio")
    settled(page)
    page.evaluate(
        """() => {
          window.scales = new Set();
          const canvas = document.getElementById('canvas');
          new MutationObserver(() => window.scales.add(canvas.dataset.scale))
            .observe(canvas, { attributes: true, attributeFilter: ['data-seq'] });
        }"""
    )
    slide(page, "Rotation", -150)
    settled(page)
    assert page.evaluate("[...window.scales].sort()")[0] == "1"
    assert page.evaluate("window.scales.size") >= 1
    names = page.evaluate("document.getElementById('status-time').title")
    assert "environment" in names


def test_even_light_takes_a_colour(visit: Any) -> None:
    page: Page = visit.page
    settled(page)
    choose(page, "Even")
    grey = settled(page)
    page.get_by_label("Even radiance").fill("#0000ff")
    blue = settled(page)
    floor = (slice(105, 122), slice(30, 98))
    assert blue[floor][..., 0].mean() < grey[floor][..., 0].mean() - 3
    assert not page.get_by_label("Rotation", exact=True).is_visible()
    choose(page, "None")
    assert page.locator("#environment .field").count() == 0


def test_a_sun_light_and_the_sky_s_sun_move_as_one(visit: Any) -> None:
    page: Page = visit.page
    settled(page)
    choose(page, "Sky")
    noon = settled(page)
    slide(page, "Sun azimuth", 180)
    slide(page, "Sun height", 20)
    low = settled(page)
    assert np.abs(low - noon).mean() > 1
    assert exact(page, "Sun height") == pytest.approx(20)
    # A sun light that is put where the sky has its sun goes along with it, and takes it along.
    page.select_option("#add", "sun")
    angles = {"x": 0.0, "y": -0.342, "z": -0.940}
    for axis, value in angles.items():
        page.get_by_label(f"Direction {axis}").fill(str(value))
        page.keyboard.press("Enter")
    page.locator("h2", has_text="Environment").click()
    slide(page, "Sun height", 50)
    assert float(page.get_by_label("Direction y").input_value()) == pytest.approx(-0.766, abs=2e-3)
    page.get_by_label("Direction y").fill("-0.3")
    page.keyboard.press("Enter")
    assert exact(page, "Sun height") == pytest.approx(25, abs=0.5)
    # The map's turn takes the sun along too.
    slide(page, "Rotation", 90)
    assert float(page.get_by_label("Direction x").input_value()) == pytest.approx(-0.906, abs=5e-3)
    page.get_by_role("button", name="Remove").click()
    page.get_by_role("button", name="Reset environment").click()
    settled(page)


def test_the_panel_in_both_pictures_is_named(visit: Any) -> None:
    """Every control of every map has a name, and what it says fits its column."""
    page: Page = visit.page
    for kind in ("Studio", "Even", "Sky", "Black"):
        choose(page, kind)
        nameless = page.evaluate(
            """() => [...document.querySelectorAll('#light-side button, #light-side input, select')]
              .filter((n) => n.checkVisibility())
              .filter((n) => !n.getAttribute('aria-label') && !n.labels?.length)
              .filter((n) => !n.textContent.trim())
              .map((n) => n.outerHTML)"""
        )
        assert nameless == []
        side = page.locator("#light-side")
        assert side.evaluate("(n) => n.scrollWidth <= n.clientWidth"), kind
    ids = page.evaluate("[...document.querySelectorAll('[id]')].map((n) => n.id)")
    assert len(ids) == len(set(ids))
    choose(page, "None")
    assert pixels(page).shape == (128, 128, 3)


def pull(page: Page, mark: str, dx: float, dy: float) -> None:
    """Take a mark of the pad, or its open ground, and move it by parts of the pad."""
    page.locator("#pad").scroll_into_view_if_needed()
    pad = page.locator("#pad").bounding_box()
    assert pad is not None
    x, y = pad["x"] + 0.1 * pad["width"], pad["y"] + 0.9 * pad["height"]
    if mark:
        box = page.locator(f".mark.{mark}").bounding_box()
        assert box is not None
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(x + dx * pad["width"] * k / 8, y + dy * pad["height"] * k / 8)
        page.wait_for_timeout(16)
    page.mouse.up()


def test_the_sun_and_the_map_are_dragged_on_the_pad(visit: Any) -> None:
    page: Page = visit.page
    settled(page)
    assert page.locator("#pad").is_hidden()
    with page.expect_response("**/environment"):
        choose(page, "Sky")
    before = settled(page)
    # The pad shows the sky: blue above, the ground below.
    column = page.evaluate(
        """() => [...document.querySelector('#pad canvas').getContext('2d')
          .getImageData(9, 0, 1, 256).data]"""
    )
    above, below = column[4 * 40 : 4 * 40 + 3], column[4 * 240 : 4 * 240 + 3]
    assert above[2] > above[0] > 0
    assert above != below
    height, azimuth = exact(page, "Sun height"), exact(page, "Sun azimuth")
    pull(page, "sun", 0.25, 0.05)
    assert exact(page, "Sun azimuth") == pytest.approx(azimuth + 90, abs=3)
    assert exact(page, "Sun height") == pytest.approx(height - 9, abs=2)
    assert np.abs(settled(page) - before).mean() > 0.2
    # It does not set below the horizon.
    pull(page, "sun", 0, 0.4)
    assert exact(page, "Sun height") == pytest.approx(0, abs=1e-9)
    page.locator(".mark.sun").focus()
    page.keyboard.press("ArrowUp")
    assert exact(page, "Sun height") == pytest.approx(2, abs=0.1)
    label = page.locator(".mark.sun").get_attribute("aria-label")
    assert label is not None
    assert label.startswith("Sun, azimuth")
    # The ground under the hand goes along: to the right by a quarter is a turn by -90 degrees.
    pull(page, "", 0.25, 0)
    assert exact(page, "Rotation") == pytest.approx(-90, abs=2)
    page.get_by_role("button", name="Reset environment").click()
    settled(page)


def test_an_area_light_alone(visit: Any) -> None:
    """Black around it; it is dragged, grows, and goes."""
    page: Page = visit.page
    for name in ("ceiling on", "key on"):
        page.get_by_label(name).uncheck()
    settled(page)
    choose(page, "Black")
    assert page.get_by_label("Area light", exact=True).is_checked()
    # The box is open to where the light stands at first, and closed to the other side.
    start = page.locator(".mark.lamp").bounding_box()
    lit = settled(page)
    pull(page, "lamp", 0.5, 0)
    moved = page.locator(".mark.lamp").bounding_box()
    assert start is not None
    assert moved is not None
    assert moved["x"] > start["x"] + 100
    assert settled(page).mean() < lit.mean() - 10
    pull(page, "lamp", -0.5, 0)
    np.testing.assert_allclose(settled(page).mean(), lit.mean(), rtol=0.05)
    slide(page, "Light radius", 20)
    assert exact(page, "Light radius") == 20
    assert settled(page).mean() > lit.mean() + 2
    page.get_by_label("Area light", exact=True).uncheck()
    assert page.locator(".mark.lamp").is_hidden()
    assert settled(page).max() == 0
    page.get_by_role("button", name="Reset environment").click()
    page.locator("#reset").click()
    settled(page)


def test_a_map_of_one_s_own_is_opened(visit: Any) -> None:
    page: Page = visit.page
    settled(page)
    image = np.zeros((16, 32, 3), np.float32)
    image[..., 2] = 2
    blue = {"name": "evening.exr", "mimeType": "image/x-exr", "buffer": encode_exr(image)}
    page.locator("#map-file").set_input_files(blue)  # type: ignore[arg-type]
    page.wait_for_function(
        "() => document.getElementById('environment-map').selectedOptions[0].text === 'evening.exr'"
    )
    lit = settled(page)
    floor = (slice(105, 122), slice(30, 98))
    choose(page, "None")
    bare = settled(page)
    assert lit[floor][..., 2].mean() > bare[floor][..., 2].mean() + 3
    # It can be chosen again, and what is no map is said beside the picture.
    choose(page, "evening.exr")
    np.testing.assert_allclose(settled(page), lit, atol=1)
    assert visit.errors == []
    text = {"name": "notes.hdr", "mimeType": "text/plain", "buffer": b"no map at all"}
    page.locator("#map-file").set_input_files(text)  # type: ignore[arg-type]
    page.wait_for_function("() => document.body.innerText.includes('notes.hdr')")
    assert "neither an OpenEXR" in page.locator("#problem").inner_text()
    assert page.locator("#map-open").is_enabled()
    assert len(visit.errors) == 1
    assert "422" in visit.errors.pop()
    page.get_by_role("button", name="Reset environment").click()
    settled(page)
