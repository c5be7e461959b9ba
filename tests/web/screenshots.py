"""The pictures of the page in the README, made by the page itself: `make screenshots`.

    python tests/web/screenshots.py [FOLDER]

Starts the service on the built-in scenes, waits for what it has to precompute, and drives the page
as a person does. Takes minutes the first time: products are kept as always.
"""

from __future__ import annotations

import io
import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from PIL import Image, ImageOps
from playwright.sync_api import Browser, Page, sync_playwright

ROOT = Path(__file__).resolve().parents[2]
ARGS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
WIDE = {"width": 1280, "height": 800}
NARROW = {"width": 390, "height": 844}
MOST = 300_000  # bytes of a picture
BITS = 8, 7, 6, 5, 4  # of a channel
WAIT_MS = 1_800_000  # for a precompute
SETTLED = """(method) => {
  const { dataset } = document.getElementById('canvas');
  return dataset.state === 'final' && dataset.method === method && dataset.preview !== 'true';
}"""


def main(folder: Path) -> None:
    """All of them."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with serving() as address, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=ARGS)
        for name, (scene, options, draw) in PICTURES.items():
            with page_of(browser, f"{address}?scene={scene}", options) as page:
                draw(page)
                save(page, folder / f"page-{name}.png")
        browser.close()


@contextmanager
def serving() -> Iterator[str]:
    """A service of its own; its address."""
    command = [sys.executable, "-m", "engine.cli", "serve", "--port", "0"]
    process = subprocess.Popen(command, cwd=ROOT, stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None
    try:
        address = re.search(r"http://\S+", process.stdout.readline())
        assert address, "the service does not say where it is"
        yield address[0]
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(timeout=60)
        process.stdout.close()


@contextmanager
def page_of(browser: Browser, address: str, options: dict[str, Any]) -> Iterator[Page]:
    """The page, its first steps put away."""
    context = browser.new_context(**options)
    page = context.new_page()
    page.goto(address)
    page.wait_for_selector("canvas[data-seq]", timeout=WAIT_MS)
    page.get_by_role("button", name="Got it").click()
    yield page
    context.close()


def settled(page: Page, method: str = "direct_to_indirect") -> None:
    """Wait for the lossless picture by a method."""
    page.wait_for_function(SETTLED, arg=method, timeout=WAIT_MS)


def take(page: Page, light: str, grip: str = "position") -> None:
    """The mouse over a grip of a light, its button down."""
    box = page.locator(f".handle[data-light={light}][data-grip={grip}]").bounding_box()
    assert box is not None
    page.mouse.move(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2)
    page.mouse.down()


def pull(page: Page, dx: float, dy: float, light: str, grip: str = "position") -> None:
    """Drag a grip by pixels of the screen."""
    box = page.locator(f".handle[data-light={light}][data-grip={grip}]").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    take(page, light, grip)
    page.mouse.move(x + dx, y + dy, steps=8)
    page.mouse.up()


def lights(page: Page) -> None:
    """The room: two lights at once, one of them locked."""
    settled(page)
    page.locator("#lights button.name", has_text="lamp").click()
    pull(page, 70, 60, "lamp", "target")
    page.get_by_role("button", name="Lock hall").click()
    page.locator("#lights button.name", has_text="key").click()
    page.locator("#lights button.name", has_text="lamp").click(modifiers=["Control"])
    page.get_by_label("Multiplier, exact").fill("2")
    page.keyboard.press("Enter")
    settled(page)


def materials(page: Page) -> None:
    """The knot, of copper."""
    box = page.locator("#picture").bounding_box()
    assert box is not None
    page.mouse.click(box["x"] + box["width"] / 4, box["y"] + box["height"] / 2)
    page.keyboard.press("Escape")
    page.locator("#editor-list .selected", has_text="brushed").wait_for()
    page.locator("#editor select").first.select_option("preset copper")
    settled(page, "brdf_editing")
    # The first frame is one that sets up; what is told shall be of one as they are.
    page.get_by_label("Roughness", exact=True).press("ArrowLeft")
    settled(page, "brdf_editing")
    page.get_by_role("button", name="Materials", exact=True).click()


def compared(page: Page) -> None:
    """The box before and after, side by side."""
    settled(page)
    page.get_by_role("button", name="Take").click()
    page.wait_for_selector("#snapshots li")
    page.get_by_label("ceiling on").uncheck()
    page.locator("#lights button.name", has_text="key").click()
    page.get_by_label("Colour", exact=True).fill("#ff9a3c")
    page.get_by_label("Multiplier, exact").fill("4")
    page.keyboard.press("Enter")
    pull(page, 150, 60, "key")
    pull(page, -20, -160, "key", "target")
    page.get_by_role("button", name="Compare with snapshot 1").click()
    page.get_by_label("Side by side").check()
    settled(page)


def narrow(page: Page) -> None:
    """The box on a telephone."""
    settled(page)
    page.locator("#lights button.name", has_text="key").click()
    pull(page, 60, 30, "key")
    settled(page)
    page.get_by_role("button", name="Lights", exact=True).click()


PICTURES: dict[str, tuple[str, dict[str, Any], Callable[[Page], None]]] = {
    "lights": ("room", {"viewport": WIDE, "color_scheme": "dark"}, lights),
    "materials": ("knot", {"viewport": WIDE, "color_scheme": "light"}, materials),
    "compared": ("cornell-box", {"viewport": WIDE, "color_scheme": "dark"}, compared),
    "narrow": (
        "cornell-box",
        {"viewport": NARROW, "color_scheme": "dark", "has_touch": True},
        narrow,
    ),
}


def save(page: Page, path: Path) -> None:
    """With as many bits of a channel as fit."""
    picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
    for bits in BITS:
        ImageOps.posterize(picture, bits).save(path, optimize=True)
        if path.stat().st_size <= MOST:
            break
    print(f"{path}: {path.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "docs")
