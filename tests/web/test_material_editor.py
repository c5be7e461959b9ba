"""Editing materials on the page by mouse and keys: picking, undo, comparison, copies, presets."""

from __future__ import annotations

import io
import json
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any

import httpx
import numpy as np
import pytest
from numpy.typing import NDArray
from PIL import Image
from playwright.sync_api import Browser, Page
from web.test_page import REST, drag

pytestmark = pytest.mark.web

Visiting = Callable[..., AbstractContextManager[Any]]
RED, GREEN, MARGIN = (0.08, 0.5), (0.92, 0.5), (0.005, 0.5)  # places of the picture
QUICK = {"gather_samples": 1024, "view_rays": 64, "bounce_rays": 32}
# The red wall, and what of the picture no other material comes near.
WALL = (slice(40, 90), slice(6, 20))


@pytest.fixture(scope="module")
def ready(address: str) -> str:
    """The address of a service that has the method's product."""
    with httpx.Client(base_url=address, timeout=120) as client:
        wanted = {"method": "brdf_editing", "settings": QUICK}
        job = client.post("/api/scenes/box/precompute", json=wanted).json()
        while client.get(f"/api/jobs/{job['id']}").json()["status"] in ("queued", "running"):
            time.sleep(0.2)
        assert client.get(f"/api/jobs/{job['id']}").json()["status"] == "done"
    return address


@pytest.fixture
def editing(browser: Browser, ready: str, visiting: Visiting) -> Iterator[Any]:
    """A page on which materials are edited, and its first picture has come."""
    permissions = ["clipboard-read", "clipboard-write"]
    with visiting(browser, ready, permissions=permissions) as visit:
        visit.page.locator("#methods [data-method=brdf_editing]").click()
        settled(visit.page)
        yield visit


def settled(page: Page) -> NDArray[np.float64]:
    """What is to be seen in the place of the picture, once it is final."""
    page.wait_for_selector("canvas[data-method=brdf_editing]", timeout=90_000)
    page.wait_for_function(REST, timeout=90_000)
    return seen(page)


def seen(page: Page) -> NDArray[np.float64]:
    """What is to be seen in the place of the picture, in its own pixels."""
    shot = page.locator(".stage").screenshot()
    box, stage = page.locator("#picture").bounding_box(), page.locator(".stage").bounding_box()
    assert box is not None
    assert stage is not None
    left, top = box["x"] - stage["x"], box["y"] - stage["y"]
    image = Image.open(io.BytesIO(shot)).convert("RGB")
    cut = image.crop((left, top, left + box["width"], top + box["height"]))
    return np.asarray(cut.resize((128, 128), Image.Resampling.BOX), np.float64)


def place(page: Page, at: tuple[float, float]) -> tuple[float, float]:
    box = page.locator("#picture").bounding_box()
    assert box is not None
    return box["x"] + at[0] * box["width"], box["y"] + at[1] * box["height"]


def click(page: Page, at: tuple[float, float]) -> None:
    """On a place of the picture; the service answers before this returns."""
    with page.expect_response("**/pick?*"):
        page.mouse.click(*place(page, at))
    page.wait_for_timeout(50)


def pull(page: Page, label: str, to: float) -> None:
    """Take a slider by the mouse and draw it to a part of its length."""
    slider = page.get_by_label(label, exact=True)
    box = slider.bounding_box()
    assert box is not None
    value, low, high = slider.evaluate("(n) => [n.valueAsNumber, Number(n.min), Number(n.max)]")
    start, y = (value - low) / (high - low), box["y"] + box["height"] / 2
    # A thumb's middle stays within the slider.
    x = [box["x"] + 8 + part * (box["width"] - 16) for part in (start, to)]
    page.mouse.move(x[0], y)
    page.mouse.down()
    for k in range(1, 9):
        page.mouse.move(x[0] + (x[1] - x[0]) * k / 8, y)
        page.wait_for_timeout(20)
    page.mouse.up()


def exact(page: Page, label: str) -> float:
    return float(page.get_by_label(f"{label}, exact").input_value())


def in_hand(page: Page) -> str:
    return page.locator("#editor-list .selected .name").inner_text()


def test_a_click_picks_what_is_there_and_a_drag_does_not(editing: Any) -> None:
    page: Page = editing.page
    picks: list[str] = []
    page.on("request", lambda r: picks.append(r.url) if "/pick" in r.url else None)
    assert page.locator("#picture").evaluate("(n) => getComputedStyle(n).cursor") == "pointer"
    click(page, RED)
    assert in_hand(page) == "red"
    assert page.locator("#editor h3").inner_text().startswith("red")
    click(page, GREEN)
    assert in_hand(page) == "green"
    # Where nothing is the one in hand stays.
    click(page, MARGIN)
    assert in_hand(page) == "green"
    page.mouse.move(*place(page, RED))
    page.mouse.down()
    page.mouse.move(*place(page, (0.2, 0.5)), steps=4)
    page.mouse.move(*place(page, RED), steps=4)
    page.mouse.move(*place(page, (0.12, 0.5)))
    page.mouse.up()
    page.mouse.click(*place(page, RED), button="right")
    page.wait_for_timeout(200)
    assert len(picks) == 3
    assert in_hand(page) == "green"


RECORD = """() => {
  window.sent = [];
  const { send } = WebSocket.prototype;
  WebSocket.prototype.send = function (text) {
    window.sent.push(text);
    send.call(this, text);
  };
}"""


def test_what_is_picked_is_taken_in_hand_at_once(editing: Any) -> None:
    """The service hears of it before a slider moves; the picture stays, nothing is to be undone."""
    page: Page = editing.page
    before = seen(page)
    page.evaluate(RECORD)
    click(page, GREEN)
    assert np.abs(settled(page) - before).max() < 2
    sent = [json.loads(text) for text in page.evaluate("window.sent")]
    edits = [message["edits"]["materials"] for message in sent if "edits" in message]
    assert edits
    assert all(list(each)[-1] == "green" and each["green"] == {} for each in edits)
    assert page.locator("#undo").is_disabled()


def test_a_click_sees_through_the_camera_of_the_page(editing: Any) -> None:
    page: Page = editing.page
    click(page, RED)
    picks: list[str] = []
    page.on("request", lambda r: picks.append(r.url) if "/pick" in r.url else None)
    # Camera mode: the same drag turns the camera, however little it is.
    page.get_by_role("button", name="Move camera").click()
    x, y = place(page, GREEN)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 2, y)
    page.mouse.up()
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 80, y, steps=8)
    page.mouse.up()
    page.wait_for_timeout(200)
    assert picks == []
    # The hand has drawn the green wall to the right, out of the picture.
    page.get_by_role("button", name="Move camera").click()
    click(page, (0.78, 0.5))
    turned = in_hand(page)
    page.get_by_role("button", name="Reset view").click()
    click(page, (0.78, 0.5))
    assert {turned, in_hand(page)} == {"back wall", "green"}


def test_a_drag_of_a_slider_is_one_step(editing: Any) -> None:
    page: Page = editing.page
    undo, redo = (page.get_by_role("button", name=name) for name in ("Undo", "Redo"))
    assert undo.is_disabled()
    before = settled(page)
    click(page, RED)
    start = exact(page, "Diffuse")
    pull(page, "Diffuse", 0.1)
    assert exact(page, "Diffuse") == pytest.approx(10, abs=2)
    dark = settled(page)
    assert dark[WALL].mean() < 0.6 * before[WALL].mean()
    pull(page, "Diffuse", 0.9)
    bright = settled(page)
    # By keys, while the slider still has the focus.
    page.keyboard.press("Control+z")
    np.testing.assert_array_equal(settled(page), dark)
    assert exact(page, "Diffuse") == pytest.approx(10, abs=2)
    assert page.get_by_label("Diffuse", exact=True).evaluate("(n) => n.valueAsNumber") < 13
    page.keyboard.press("Control+z")
    # The first picture was made with another material in hand: in sixteen bits it is another one.
    np.testing.assert_allclose(settled(page), before, atol=1)
    assert exact(page, "Diffuse") == start
    assert undo.is_disabled()
    page.keyboard.press("Control+Shift+Z")
    np.testing.assert_array_equal(settled(page), dark)
    page.keyboard.press("Control+y")
    np.testing.assert_array_equal(settled(page), bright)
    assert redo.is_disabled()
    # By the buttons; a new edit drops what could be redone.
    undo.click()
    np.testing.assert_array_equal(settled(page), dark)
    assert redo.is_enabled()
    page.get_by_label("Diffuse, exact").fill("50")
    page.keyboard.press("Enter")
    assert redo.is_disabled()
    undo.click()
    np.testing.assert_array_equal(settled(page), dark)
    redo.click()
    assert exact(page, "Diffuse") == 50


def test_what_is_typed_and_not_yet_taken_is_a_step_too(editing: Any) -> None:
    page: Page = editing.page
    click(page, GREEN)
    start = exact(page, "Diffuse")
    page.get_by_label("Diffuse, exact").fill("12")
    page.keyboard.press("Control+z")
    assert exact(page, "Diffuse") == start
    page.keyboard.press("Control+y")
    assert exact(page, "Diffuse") == 12


def test_a_colour_outlasts_black(editing: Any) -> None:
    page: Page = editing.page
    click(page, RED)
    tint = page.get_by_label("Diffuse colour").input_value()
    pull(page, "Diffuse", 0)
    assert exact(page, "Diffuse") == 0
    pull(page, "Diffuse", 0.5)
    assert exact(page, "Diffuse") > 40
    assert page.get_by_label("Diffuse colour").input_value() == tint


def test_the_history_is_bounded(editing: Any) -> None:
    page: Page = editing.page
    click(page, RED)
    page.get_by_label("Diffuse, exact").fill("10")
    page.get_by_label("Diffuse", exact=True).focus()
    for _ in range(105):
        page.keyboard.press("ArrowRight")
    assert exact(page, "Diffuse") == 62.5
    for _ in range(120):
        page.keyboard.press("Control+z")
    assert exact(page, "Diffuse") == 12.5
    assert page.get_by_role("button", name="Undo").is_disabled()


def test_lights_and_environment_are_undone_too(visit: Any) -> None:
    page: Page = visit.page
    undo = page.get_by_role("button", name="Undo")
    page.locator(".lights button.name", has_text="key").click()
    x = page.get_by_label("Position x")
    start = x.input_value()
    drag(page, "key", 60, 0)
    dragged = x.input_value()
    assert dragged != start
    # A key moves it by a step of its own.
    page.keyboard.press("Shift+ArrowLeft")
    assert x.input_value() != dragged
    page.get_by_label("Environment map").select_option(label="Studio")
    page.select_option("#add", "point")
    page.keyboard.press("Control+z")
    assert page.locator(".lights button.name", has_text="point-1").count() == 0
    page.keyboard.press("Control+z")
    assert page.get_by_label("Environment map").input_value() == "none"
    page.keyboard.press("Control+z")
    assert x.input_value() == dragged
    page.keyboard.press("Control+z")
    assert x.input_value() == start
    assert undo.is_disabled()


COUNT = """() => {
  const send = WebSocket.prototype.send;
  window.edits = 0;
  WebSocket.prototype.send = function (text) {
    if (JSON.parse(text).type === 'edit') window.edits += 1;
    send.call(this, text);
  };
}"""


def test_the_picture_before_is_shown_while_a_key_or_a_button_is_held(editing: Any) -> None:
    page: Page = editing.page
    before = settled(page)
    click(page, RED)
    pull(page, "Diffuse", 0.9)
    edited = settled(page)
    assert np.abs(edited - before).max() > 20
    page.evaluate(COUNT)
    frames: list[str] = []
    page.on("request", lambda r: frames.append(r.url) if "/frame" in r.url else None)
    page.keyboard.down("b")
    np.testing.assert_array_equal(seen(page), before)
    assert page.locator("#compare").get_attribute("aria-pressed") == "true"
    page.keyboard.up("b")
    np.testing.assert_array_equal(seen(page), edited)
    page.locator("#compare").hover()
    page.mouse.down()
    np.testing.assert_array_equal(seen(page), before)
    # Wherever the button is let go.
    page.mouse.move(400, 300)
    page.mouse.up()
    np.testing.assert_array_equal(seen(page), edited)
    assert page.locator("#compare").get_attribute("aria-pressed") == "false"
    # Nothing was asked for: what the service holds in its hand stays there.
    assert page.evaluate("window.edits") == 0
    assert frames == []
    # Under another exposure the picture before is another one too.
    page.get_by_label("Exposure").focus()
    for _ in range(10):
        page.keyboard.press("ArrowRight")
    edited = settled(page)
    with page.expect_response("**/frame?*"):
        page.keyboard.down("b")
    page.wait_for_selector("#before:not([hidden])")
    bright = seen(page)
    page.keyboard.up("b")
    np.testing.assert_array_equal(seen(page), edited)
    page.get_by_role("button", name="Reset materials").click()
    np.testing.assert_allclose(settled(page), bright, atol=1)
    assert bright[WALL].mean() > 1.2 * before[WALL].mean()


def test_a_copied_material_is_an_edit(editing: Any, ready: str) -> None:
    page: Page = editing.page
    click(page, RED)
    page.get_by_label("Type").select_option(label="Blinn-phong")
    pull(page, "Exponent", 0.8)
    page.get_by_label("Specular colour").fill("#40a0ff")
    page.get_by_role("button", name="Copy", exact=True).click()
    page.get_by_role("button", name="Copied").wait_for()
    text = page.evaluate("navigator.clipboard.readText()")
    copied = json.loads(text)
    assert set(copied) == {"red"}
    assert set(copied["red"]) == {"type", "diffuse", "specular", "exponent"}
    assert copied["red"]["exponent"] == pytest.approx(exact(page, "Exponent"), rel=1e-3)
    answer = httpx.post(
        f"{ready}api/scenes/box/frame",
        json={"materials": copied},
        params={"method": "brdf_editing"},
        headers={"Accept": "image/png"},
        timeout=60,
    )
    assert answer.status_code == 200, answer.text
    drawn = np.asarray(Image.open(io.BytesIO(answer.content)), np.float64)
    settled(page)
    shown = page.evaluate(
        """() => { const canvas = document.getElementById('canvas');
          const { width, height } = canvas;
          return [...canvas.getContext('2d').getImageData(0, 0, width, height).data]; }"""
    )
    np.testing.assert_allclose(np.reshape(shown, (128, 128, 4))[..., :3], drawn, atol=1)
    # Where the browser refuses, the text is there to be copied by hand.
    page.evaluate("() => { navigator.clipboard.writeText = () => Promise.reject(new Error()); }")
    page.get_by_role("button", name="Copy", exact=True).click()
    box = page.get_by_label("Text to copy")
    bounds, side = box.bounding_box(), page.locator("#editor").bounding_box()
    assert bounds is not None
    assert side is not None
    assert bounds["width"] == side["width"]
    assert box.input_value() == text
    assert box.evaluate("(n) => n.value.slice(n.selectionStart, n.selectionEnd)") == text
    assert box.evaluate("(n) => n === document.activeElement")
    page.keyboard.press("Tab")
    assert box.count() == 0


def test_metals_and_plastics_are_chosen_by_name(editing: Any) -> None:
    page: Page = editing.page
    before = settled(page)
    click(page, RED)
    groups = page.get_by_label("Type").evaluate(
        """(n) => [...n.querySelectorAll('optgroup')]
          .map((g) => [g.label, [...g.children].map((o) => o.text)])"""
    )
    names = dict(groups)
    assert list(names) == ["Type", "Matt", "Metals", "Plastics", "Wang et al. 2006"]
    assert {"gold", "silver", "copper", "aluminium", "titanium"} <= set(names["Metals"])
    # Clay and skin are of a type that cannot be edited at once.
    assert names["Wang et al. 2006"] == ["red Phong", "Ashikhmin-Shirley"]
    page.get_by_label("Type").select_option(label="gold")
    gold = settled(page)
    assert np.abs(gold - before)[WALL].mean() > 10
    assert (exact(page, "Diffuse"), exact(page, "Specular")) == (0, 100)
    assert page.locator("#editor-list .selected .kind").inner_text() == "Cook-torrance"
    assert page.get_by_label("Type").evaluate("(n) => n.selectedOptions[0].text") == "gold"
    # It is gold no longer once it is changed.
    page.get_by_label("Roughness, exact").fill("0.5")
    page.keyboard.press("Enter")
    assert page.get_by_label("Type").evaluate("(n) => n.selectedOptions[0].text") == "Cook-torrance"
    page.keyboard.press("Control+z")
    assert page.get_by_label("Type").evaluate("(n) => n.selectedOptions[0].text") == "gold"
    # Everything of every type has a name of its own and fits its column.
    for kind in ("GGX", "Ashikhmin-shirley", "Phong", "Diffuse"):
        page.get_by_label("Type").select_option(label=kind)
        ids = page.evaluate("[...document.querySelectorAll('[id]')].map((n) => n.id)")
        assert len(ids) == len(set(ids))
        side = page.locator("#light-side")
        assert side.evaluate("(n) => n.scrollWidth <= n.clientWidth"), kind
