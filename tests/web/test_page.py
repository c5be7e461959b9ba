"""A person's first minutes on the page, in a real browser."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from axe_playwright_python.sync_playwright import Axe
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Browser, Page
from web.conftest import fresh

pytestmark = pytest.mark.web


@pytest.fixture(scope="module")
def address(scene_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The first test looks on while the service precomputes."""
    with fresh(scene_file, tmp_path_factory.mktemp("store")) as address:
        yield address


REST = "() => document.getElementById('canvas').dataset.state === 'final'"
INDIRECT = "() => !['direct', undefined].includes(document.getElementById('canvas').dataset.method)"


def pixels(page: Page) -> NDArray[np.float64]:
    """What the canvas shows."""
    url = page.evaluate("document.getElementById('canvas').toDataURL('image/png')")
    data = base64.b64decode(url.split(",")[1])
    return np.asarray(Image.open(io.BytesIO(data)).convert("RGB"), np.float64)


def settled(page: Page) -> NDArray[np.float64]:
    """The lossless picture of the last edit, indirect light included."""
    page.wait_for_function(f"() => ({REST})() && ({INDIRECT})()", timeout=90_000)
    return pixels(page)


def light(page: Page, name: str) -> dict[str, Any]:
    """Position of a light, as the panel shows it."""
    page.locator(".lights button.name", has_text=name).click()
    return {
        axis: float(page.get_by_label(f"Position {axis}").input_value()) for axis in ("x", "y", "z")
    }


def drag(page: Page, name: str, dx: float, dy: float, grip: str = "position") -> None:
    """Take a handle and move it by pixels of the screen, as a hand does."""
    box = page.locator(f".handle[data-light={name}][data-grip={grip}]").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 13):
        page.mouse.move(x + dx * step / 12, y + dy * step / 12)
        page.wait_for_timeout(16)
    page.mouse.up()


def test_direct_light_first_then_progress_then_indirect(visit: Any) -> None:
    """Runs first: the precompute is still going on."""
    page: Page = visit.page
    assert page.evaluate("document.getElementById('canvas').dataset.method") == "direct"
    page.wait_for_selector("#progress:not([hidden])")
    direct = pixels(page)
    assert direct.mean() > 5
    assert "Computing indirect light" in page.inner_text("#progress-text") or page.evaluate(
        INDIRECT
    )
    assert "direct light" in page.inner_text("#status-warnings").lower() or page.evaluate(INDIRECT)
    full = settled(page)
    assert page.locator("#progress").is_hidden()
    assert page.inner_text("#status-method") == "Direct-to-indirect transfer"
    # The ceiling gets no light but what comes back from the room.
    assert full[14:26, 40:88].mean() > direct[14:26, 40:88].mean() + 8


def test_a_dragged_light_moves_the_picture_where_it_should(visit: Any) -> None:
    page: Page = visit.page
    page.get_by_label("ceiling on").uncheck()
    light(page, "key")
    drag(page, "key", 150, 0, "target")
    drag(page, "key", 150, 0)
    right = settled(page)
    at_right = light(page, "key")
    drag(page, "key", -250, 0, "target")
    drag(page, "key", -250, 0)
    left = settled(page)
    at_left = light(page, "key")
    # The picture's left is at large x; the depth and the height stay as they are.
    assert at_left["x"] > at_right["x"] + 0.05
    assert at_left["z"] == pytest.approx(at_right["z"], abs=2e-3)
    assert at_left["y"] == pytest.approx(at_right["y"], abs=2e-3)
    # Direct light goes along with the hand ...
    floor = slice(105, 122)
    assert left[floor, 20:50].mean() > right[floor, 20:50].mean() + 10
    assert right[floor, 80:110].mean() > left[floor, 80:110].mean() + 10

    # ... and so does what bounces off the coloured walls onto the back wall and the ceiling.
    def redness(image: NDArray[np.float64]) -> float:
        ceiling = image[6:24, 30:98].mean((0, 1))
        return float(ceiling[0] / ceiling[1])

    assert redness(left) > redness(right) * 1.05


def test_keys_move_a_light(visit: Any) -> None:
    page: Page = visit.page
    before = settled(page)
    start = light(page, "key")
    handle = page.locator(".handle[data-light=key][data-grip=position]")
    handle.focus()
    for _ in range(5):
        page.keyboard.press("Shift+ArrowRight")
    moved = light(page, "key")
    assert moved["x"] < start["x"] - 0.05
    handle.focus()
    page.keyboard.press("Alt+ArrowUp")
    fine = light(page, "key")
    assert 0 <= fine["y"] - moved["y"] < 0.003
    handle.focus()
    page.keyboard.press("PageUp")
    assert light(page, "key")["z"] > fine["z"]
    after = settled(page)
    assert np.abs(after - before).max() > 30
    handle.focus()
    page.keyboard.press("Space")
    assert not page.get_by_label("key on").is_checked()


def test_tab_reaches_the_handles(visit: Any) -> None:
    page: Page = visit.page
    page.locator("#picture").focus()
    page.keyboard.press("Tab")
    label = page.evaluate("document.activeElement.getAttribute('aria-label')")
    assert label.startswith("Light ceiling, position")
    assert page.evaluate("getComputedStyle(document.activeElement).outlineStyle") == "solid"


def test_wheel_changes_depth_and_nothing_else_on_the_picture(visit: Any) -> None:
    page: Page = visit.page
    start = light(page, "key")
    handle = page.locator(".handle[data-light=key][data-grip=position]")
    before = handle.bounding_box()
    handle.hover()
    page.mouse.wheel(0, -100)
    page.wait_for_timeout(100)
    after = handle.bounding_box()
    assert light(page, "key")["z"] > start["z"]
    assert before is not None
    assert after is not None
    assert abs(after["x"] - before["x"]) < 1
    assert abs(after["y"] - before["y"]) < 1


def test_intensity_colour_exposure_and_reset(visit: Any) -> None:
    page: Page = visit.page
    original = settled(page)
    page.locator(".lights button.name", has_text="ceiling").click()
    page.get_by_label("Colour", exact=True).fill("#ff0000")
    red = settled(page)
    back = slice(40, 60)
    assert red[back, 50:80, 1].mean() < original[back, 50:80, 1].mean() - 5
    page.get_by_label("Intensity, exact").fill("1")
    page.keyboard.press("Enter")
    assert settled(page).mean() < red.mean() - 5
    page.locator("#reset").click()
    np.testing.assert_allclose(settled(page), original, atol=1)
    page.locator("#exposure").focus()
    for _ in range(10):
        page.keyboard.press("ArrowRight")
    assert page.inner_text("#exposure-value") == "+1.0 EV"
    assert settled(page).mean() > original.mean() + 10


KINDS = ["point", "spot", "area", "disk", "sphere", "projector", "uberlight"]


@pytest.mark.parametrize("kind", KINDS)
def test_added_lights_shine_and_can_be_removed(visit: Any, kind: str) -> None:
    page: Page = visit.page
    original = settled(page)
    page.select_option("#add", kind)
    handle = page.locator(f".handle[data-light={kind}-1][data-grip=position]")
    assert handle.is_visible()
    assert handle.locator("path").get_attribute("d"), "a mark of its own"
    brighter = settled(page)
    assert brighter.mean() > original.mean() + 1
    page.get_by_role("button", name="Remove").click()
    np.testing.assert_allclose(settled(page), original, atol=1)


def test_a_projector_throws_another_image(visit: Any) -> None:
    """A name in the panel changes the picture; a wrong one is said, and the page goes on."""
    page: Page = visit.page
    page.select_option("#add", "projector")
    window = settled(page)
    page.get_by_label("Image", exact=True).fill("chart")
    page.keyboard.press("Enter")
    chart = settled(page)
    assert np.abs(chart - window).max() > 30
    page.get_by_label("Image", exact=True).fill("none.png")
    page.keyboard.press("Enter")
    page.wait_for_function("() => document.body.innerText.includes('no such file')")
    page.get_by_label("Image", exact=True).fill("window")
    page.keyboard.press("Enter")
    page.wait_for_function("() => !document.body.innerText.includes('no such file')")
    np.testing.assert_allclose(settled(page), window, atol=1)
    page.get_by_role("button", name="Remove").click()


def test_the_uberlight_s_switches_and_pairs(visit: Any) -> None:
    """A card in the beam takes light away, and parallel rays keep to their width."""
    page: Page = visit.page
    page.select_option("#add", "uberlight")
    lit = settled(page)
    page.get_by_label("Blocker size x").fill("4")
    page.keyboard.press("Enter")
    page.get_by_label("Blocker size y").fill("4")
    page.keyboard.press("Enter")
    page.get_by_label("Blocker distance").fill("0.01")
    blocked = settled(page)
    assert blocked.mean() < lit.mean() - 1
    page.get_by_label("Blocker distance").fill("1000")
    page.get_by_label("Parallel").check()
    parallel = settled(page)
    assert parallel.mean() > blocked.mean() + 1
    assert np.abs(parallel - lit).max() > 10
    page.get_by_role("button", name="Remove").click()


@pytest.mark.parametrize("kind", ["distant", "sun"])
def test_a_light_at_infinity_follows_the_hand(visit: Any, kind: str) -> None:
    """Its handle lies on a ball around what the camera looks at, and stays on it."""
    page: Page = visit.page
    page.select_option("#add", kind)
    handle = page.locator(f".handle[data-light={kind}-1][data-grip=direction]")
    before = handle.bounding_box()
    drag(page, f"{kind}-1", 60, 45, "direction")
    after = handle.bounding_box()
    assert before is not None
    assert after is not None
    assert after["x"] - before["x"] == pytest.approx(60, abs=1.5)
    assert after["y"] - before["y"] == pytest.approx(45, abs=1.5)
    # Past the ball's rim it waits at the rim and comes back.
    drag(page, f"{kind}-1", 5000, 0, "direction")
    rim = handle.bounding_box()
    assert rim is not None
    assert rim["x"] > after["x"] + 10
    page.get_by_role("button", name="Remove").click()


def test_dragging_does_not_move_the_picture(visit: Any) -> None:
    """Whatever the status and the notes have to say meanwhile."""
    page: Page = visit.page
    places = []
    box = page.locator(".handle[data-light=key][data-grip=position]").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()
    for step in range(20):
        page.mouse.move(box["x"] + 6 * step, box["y"] + 2 * step)
        page.wait_for_timeout(16)
        places.append(page.locator("#picture").bounding_box())
    page.mouse.up()
    settled(page)
    places.append(page.locator("#picture").bounding_box())
    assert all(place == places[0] for place in places)


def test_lights_outside_the_picture_wait_at_its_border(visit: Any) -> None:
    page: Page = visit.page
    page.locator(".lights button.name", has_text="key").click()
    for axis, value in (("x", "0.278"), ("y", "3"), ("z", "0.1")):
        page.get_by_label(f"Position {axis}").fill(value)
        page.keyboard.press("Enter")
    handle = page.locator(".handle[data-light=key][data-grip=position]")
    assert handle.get_attribute("data-outside") == "true"
    box, picture = handle.bounding_box(), page.locator("#picture").bounding_box()
    assert box is not None
    assert picture is not None
    assert picture["y"] <= box["y"] + box["height"] / 2 < picture["y"] + 60
    drag(page, "key", 0, 200)
    assert handle.get_attribute("data-outside") == "false"


def test_another_camera_shows_direct_light_then_indirect(visit: Any) -> None:
    page: Page = visit.page
    before = settled(page)
    picture = page.locator("#picture").bounding_box()
    assert picture is not None
    x, y = picture["x"] + picture["width"] / 2, picture["y"] + picture["height"] * 0.6
    page.mouse.move(x, y)
    page.mouse.down(button="right")
    for step in range(10):
        page.mouse.move(x + 6 * step, y)
        page.wait_for_timeout(20)
    page.mouse.up(button="right")
    page.wait_for_function("() => document.getElementById('canvas').dataset.method === 'direct'")
    page.wait_for_selector("#progress:not([hidden])")
    after = settled(page)
    assert np.abs(after - before).mean() > 5
    page.get_by_role("button", name="Reset view").click()
    page.wait_for_timeout(500)
    np.testing.assert_allclose(settled(page), before, atol=1)


def test_touch_drags_too(browser: Browser, address: str, visiting: Any) -> None:
    with visiting(browser, address, has_touch=True) as visit:
        page = visit.page
        start = light(page, "key")
        box = page.locator(".handle[data-light=key][data-grip=position]").bounding_box()
        x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
        touch = page.context.new_cdp_session(page)
        for kind, dx in (
            ("touchStart", 0),
            ("touchMove", 40),
            ("touchMove", 80),
            ("touchEnd", None),
        ):
            points = [] if dx is None else [{"x": x + dx, "y": y}]
            touch.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
            page.wait_for_timeout(30)
        assert light(page, "key")["x"] < start["x"] - 0.02


RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]


def violations(page: Page, scheme: Literal["dark", "light"]) -> list[str]:
    """Of WCAG A and AA, as axe finds them: names, contrast, sizes of targets."""
    page.emulate_media(color_scheme=scheme)
    found = Axe().run(page, options={"runOnly": RULES, "resultTypes": ["violations"]}).response
    return [f"{v['id']}: {node['html'][:150]}" for v in found["violations"] for node in v["nodes"]]


def test_everybody_can_use_the_page(browser: Browser, address: str, visiting: Any) -> None:
    # The page's own policy lets no script in but its own, axe neither.
    with visiting(browser, address, bypass_csp=True, reduced_motion="reduce") as visit:
        page: Page = visit.page
        assert violations(page, "dark") == []
        page.get_by_role("button", name="Got it").click()
        page.locator("#lights .name", has_text="key").click()
        assert violations(page, "light") == []
        page.locator("#editor-list .name", has_text="red").click()
        assert violations(page, "dark") == []
        page.get_by_label("Environment map").select_option(label="Golden evening")
        page.set_viewport_size({"width": 390, "height": 844})
        assert violations(page, "light") == []
        moving = "document.getAnimations().filter((a) => a.playState === 'running').length"
        assert page.evaluate(moving) == 0


def test_a_narrow_screen_keeps_the_picture_while_what_is_edited_scrolls(
    browser: Browser, address: str, visiting: Any
) -> None:
    with visiting(browser, address, has_touch=True, device_scale_factor=2) as visit:
        page = visit.page
        page.set_viewport_size({"width": 390, "height": 844})
        assert page.evaluate("document.documentElement.scrollWidth") <= 390
        page.get_by_role("button", name="Got it").tap()
        top = page.locator("#picture").bounding_box()
        assert top["width"] > 300
        page.get_by_role("button", name="Materials", exact=True).tap()
        page.wait_for_function("() => scrollY > 300")
        assert page.locator("#picture").bounding_box() == top
        main, title = (page.locator(each).bounding_box() for each in ("main", "#editor-title"))
        assert main["y"] + main["height"] <= title["y"] < 740
