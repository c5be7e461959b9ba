"""From a pointer's move to new pixels in a real browser: median and 95th percentile.

    python tests/speed/pointer_to_pixels.py http://127.0.0.1:8000/ [--light key] [--seconds 10]
    python tests/speed/pointer_to_pixels.py http://127.0.0.1:8000/ --method wavelet_brdf
    python tests/speed/pointer_to_pixels.py http://127.0.0.1:8000/ --drag camera (or environment)

The last way asks for `glossy_prt` and orbits the camera, or turns the environment.

The page itself measures each frame, from the time stamp of the pointer event that caused it to the
animation frame after its pixels are on the canvas (`performance.measure("pointer-to-pixels")`).
The service must run; the script waits for its precompute.
"""

from __future__ import annotations

import argparse
import json
import math
import shutil
import statistics
import sys
import time
from typing import Any

from playwright.sync_api import Page, sync_playwright

ARGS = ["--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking"]
MOVE_SECONDS = 1 / 60
READ = """performance.getEntriesByName('pointer-to-pixels')
  .map((entry) => ({ milliseconds: entry.duration, scale: entry.detail.scale }))"""


def measure(
    address: str,
    drag: str = "light",
    light: str | None = None,
    seconds: float = 10.0,
    method: str | None = None,
) -> dict[str, Any]:
    """Drag in circles for some seconds; what the page measured, in milliseconds."""
    chromium = shutil.which("chromium") or shutil.which("chromium-browser")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=chromium, args=ARGS)
        page = browser.new_page(viewport={"width": 1400, "height": 900})
        page.goto(address)
        wanted = "!['direct', undefined].includes(method)"
        if method is not None:
            page.locator(f"[data-method={method}]").click()
            wanted = f"method === '{method}'"
        elif drag != "light":
            page.get_by_role("radio", name="Camera and sky").click()
            wanted = "method === 'glossy_prt'"
        page.wait_for_function(
            "() => { const { method, preview } = document.getElementById('canvas').dataset; "
            f"return preview === 'false' && {wanted}; }}",
            timeout=600_000,
        )
        page.wait_for_timeout(1500)  # until the lossless frame is there too
        frames = _circle(page, drag, light, seconds)
        size = page.evaluate("[canvas.width, canvas.height]")
        browser.close()
    return {**summary(frames), "width": size[0], "height": size[1]}


def _circle(page: Page, drag: str, light: str | None, seconds: float) -> list[dict[str, float]]:
    name = f"[data-light='{light}']" if light else ""
    grip = "#canvas" if drag != "light" else f".handle{name}[data-grip=position]"
    box = page.locator(grip).last.bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    if drag == "environment":
        page.keyboard.down("Alt")
    page.mouse.move(x, y)
    page.mouse.down()
    _turn(page, x, y, 1.0)  # warm caches are what a hand at work has
    page.evaluate("performance.clearMeasures('pointer-to-pixels')")
    _turn(page, x, y, seconds)
    frames: list[dict[str, float]] = page.evaluate(READ)
    page.mouse.up()
    page.keyboard.up("Alt")
    return frames


def _turn(page: Page, x: float, y: float, seconds: float) -> None:
    start = time.monotonic()
    while (now := time.monotonic() - start) < seconds:
        angle = 2 * math.pi * now / 4
        page.mouse.move(x + 40 * math.sin(angle), y + 40 * (1 - math.cos(angle)))
        time.sleep(MOVE_SECONDS)


def summary(frames: list[dict[str, float]]) -> dict[str, Any]:
    """Count, how many are of full size; median, 95th percentile and slowest milliseconds."""
    times = sorted(frame["milliseconds"] for frame in frames)
    if len(times) < 20:
        raise SystemExit(f"only {len(times)} frames came: too few to tell anything")
    return {
        "frames": len(times),
        "full_size": sum(frame["scale"] == 1 for frame in frames),
        "median_ms": round(statistics.median(times), 1),
        "p95_ms": round(times[math.ceil(0.95 * len(times)) - 1], 1),
        "slowest_ms": round(times[-1], 1),
    }


def main() -> None:
    """Measure and print JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("address", nargs="?", default="http://127.0.0.1:8000/")
    parser.add_argument("--drag", choices=["light", "camera", "environment"], default="light")
    parser.add_argument("--light", help="id of the light to drag; the last one if not given")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--method", help="to ask for; that of the page if not given")
    options = parser.parse_args()
    json.dump(measure(**vars(options)), sys.stdout, indent=1)
    print()


if __name__ == "__main__":
    main()
