"""Choosing the method on the page: the camera and the sky by hand, in a real browser."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from typing import Any, Literal

import numpy as np
import pytest
from numpy.typing import NDArray
from playwright.sync_api import Browser, Page
from web.conftest import serve
from web.test_page import settled

pytestmark = pytest.mark.web

SIZE = 96


@pytest.fixture(scope="module")
def still_life(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """A service with a glossy ball over a floor, in the studio."""
    floor = {"shape": "rectangle", "size": [4, 4], "segments": [12, 12]}
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
            {"name": "ball", "mesh": {"shape": "sphere", "radius": 0.5, "rings": 12},
             "material": "ball"},
            {"name": "floor", "mesh": floor, "material": "floor",
             "transform": {"translate": [0, -0.51, 0], "rotate_degrees": [-90, 0, 0]}},
        ],
    }  # fmt: skip
    path = tmp_path_factory.mktemp("scene") / "ball.json"
    path.write_text(json.dumps(document))
    with serve(path, tmp_path_factory.mktemp("store"), {"gather_samples": 1024}) as address:
        yield address


def drag(
    page: Page,
    dx: int,
    dy: int,
    modifier: str | None = None,
    button: Literal["left", "middle"] = "left",
) -> None:
    box = page.locator("#picture").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    if modifier:
        page.keyboard.down(modifier)
    page.mouse.move(x, y)
    page.mouse.down(button=button)
    for k in range(1, 9):
        page.mouse.move(x + dx * k / 8, y + dy * k / 8)
        page.wait_for_timeout(20)
    page.mouse.up(button=button)
    if modifier:
        page.keyboard.up(modifier)


def test_the_camera_and_the_sky_by_hand(
    browser: Browser, still_life: str, visiting: Callable[..., AbstractContextManager[Any]]
) -> None:
    with visiting(browser, still_life) as visit:
        page: Page = visit.page
        page.get_by_role("radio", name="Camera and sky").click()
        page.wait_for_selector("canvas[data-method=glossy_prt]", timeout=120_000)
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


def glossy(page: Page) -> None:
    """Choose the method and wait for its product."""
    page.get_by_role("radio", name="Camera and sky").click()
    page.wait_for_selector("canvas[data-method=glossy_prt]", timeout=120_000)


def camera(page: Page) -> dict[str, list[float]]:
    """The camera of the last edit that was sent."""
    return page.evaluate("window.sent.edits.camera ?? {}")


WATCH = """() => {
  const send = WebSocket.prototype.send;
  WebSocket.prototype.send = function (text) {
    const message = JSON.parse(text);
    if (message.type === 'edit') window.sent = message;
    send.call(this, text);
  };
}"""


def test_the_camera_turns_shifts_and_comes_nearer(
    browser: Browser, still_life: str, visiting: Callable[..., AbstractContextManager[Any]]
) -> None:
    """By hand and by keys: what a person does, and what it does to the camera."""
    start = {"position": np.array([0.8, 1.2, 2.4]), "target": np.zeros(3)}

    def now(page: Page) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        page.wait_for_timeout(60)
        sent = {**start, **camera(page)}
        return np.array(sent["position"]), np.array(sent["target"])

    with visiting(browser, still_life) as visit:
        page: Page = visit.page
        page.evaluate(WATCH)
        glossy(page)
        settled(page)
        picture = page.locator("#picture")
        distance = float(np.linalg.norm(start["position"]))

        def turned() -> None:
            position, target = now(page)
            assert not target.any()
            assert np.linalg.norm(position) == pytest.approx(distance)
            assert np.linalg.norm(position - start["position"]) > 0.05

        def shifted() -> None:
            position, target = now(page)
            assert np.linalg.norm(target) > 0.02
            np.testing.assert_allclose(position - target, start["position"], atol=1e-6)

        def nearer() -> None:
            position, target = now(page)
            assert not target.any()
            assert np.linalg.norm(position) < 0.99 * distance

        def wheel() -> None:
            picture.hover()
            page.mouse.wheel(0, -100)

        def keys(*names: str) -> None:
            picture.focus()
            for name in names:
                page.keyboard.press(name)

        for do, check in (
            (lambda: drag(page, 60, 20), turned),
            (lambda: drag(page, 60, 20, "Shift"), shifted),
            (lambda: drag(page, 60, 20, button="middle"), shifted),
            (wheel, nearer),
            (lambda: keys("ArrowLeft", "ArrowUp"), turned),
            (lambda: keys("Shift+ArrowLeft", "Shift+ArrowUp"), shifted),
            (lambda: keys("+"), nearer),
            (lambda: keys("PageUp"), nearer),
        ):
            do()
            page.wait_for_timeout(450)
            check()
            page.get_by_role("button", name="Reset view").click()
            page.wait_for_timeout(60)


def test_without_background_the_sky_is_black(
    browser: Browser, still_life: str, visiting: Callable[..., AbstractContextManager[Any]]
) -> None:
    with visiting(browser, still_life) as visit:
        page: Page = visit.page
        glossy(page)
        shown = settled(page)
        page.get_by_label("Background", exact=True).uncheck()
        hidden = settled(page)
        sky = (slice(0, 6), slice(0, 96))
        assert shown[sky].mean() > 5
        assert hidden[sky].max() == 0
        np.testing.assert_array_equal(hidden[60:], shown[60:])
        page.get_by_role("button", name="Reset environment").click()


def test_another_material_is_precomputed_and_then_shown(
    browser: Browser, still_life: str, visiting: Callable[..., AbstractContextManager[Any]]
) -> None:
    with visiting(browser, still_life) as visit:
        page: Page = visit.page
        assert page.locator("#materials-part").is_hidden()
        glossy(page)
        before = settled(page)
        note = page.locator("#materials li", has_text="ball").locator("small")
        page.wait_for_function(
            "() => document.querySelector('#materials small')?.innerText.includes('K =')"
        )
        assert "phong · K = 5, grey · fit" in note.inner_text()
        page.get_by_label("ball", exact=True).select_option("plain diffuse")
        page.wait_for_function(
            "() => document.getElementById('progress-text').innerText.includes('lossy transport')"
        )
        assert page.locator("#progress").is_visible()
        # The old picture stays, and can be moved, until the new one is there.
        assert page.locator("#canvas").get_attribute("data-method") == "glossy_prt"
        page.wait_for_function(
            "() => document.querySelector('#materials small').innerText.includes('exact')",
            timeout=120_000,
        )
        after = settled(page)
        assert note.inner_text() == "diffuse · K = 1, grey · exact"
        assert page.locator("#progress").is_hidden()
        ball = (slice(40, 60), slice(40, 60))
        assert before[ball][..., 0].mean() > 1.5 * before[ball][..., 1].mean()
        assert after[ball][..., 0].mean() == pytest.approx(after[ball][..., 1].mean(), rel=0.1)
        page.get_by_label("ball", exact=True).select_option("As in the scene")
        np.testing.assert_allclose(settled(page), before, atol=1)
        page.get_by_role("radio", name="Lights").click()
        assert page.locator("#materials-part").is_hidden()
