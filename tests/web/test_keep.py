"""The picture as a file, the edits as JSON, the whole state as a link: all of them lead back."""

from __future__ import annotations

import json
from collections.abc import Callable
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any
from urllib.parse import quote

import numpy as np
import pytest
from PIL import Image
from playwright.sync_api import Browser, Page
from web.test_page import drag, light, pixels, settled

from engine.arguments import read_edits
from engine.images import read_image

pytestmark = pytest.mark.web

Visiting = Callable[..., AbstractContextManager[Any]]


def saved(page: Page, name: str, folder: Path) -> Path:
    """What a button saves."""
    with page.expect_download() as caught:
        page.get_by_role("button", name=name, exact=True).click()
    path = folder / caught.value.suggested_filename
    caught.value.save_as(path)
    return path


def edited(page: Page) -> np.ndarray:
    """Another picture than the scene's own: a light moved, one dimmed and one added."""
    settled(page)
    page.get_by_label("ceiling on").uncheck()
    light(page, "key")
    drag(page, "key", 80, 20)
    page.get_by_label("Add a light").select_option("point")
    page.get_by_label("Exposure").fill("1")
    return settled(page)


def test_everything_that_is_kept_leads_back(
    browser: Browser, address: str, visiting: Visiting, tmp_path: Path
) -> None:
    with visiting(browser, address) as visit:
        page: Page = visit.page
        shown = edited(page)
        picture = saved(page, "PNG", tmp_path)
        linear = saved(page, "EXR", tmp_path)
        edits = saved(page, "Edits", tmp_path)
        page.get_by_role("button", name="Copy link").click()
        page.wait_for_function(
            "() => document.getElementById('keep-told').textContent.includes('link')"
        )
        link = page.url
    assert picture.name == "box-direct_to_indirect.png"
    np.testing.assert_array_equal(np.asarray(Image.open(picture).convert("RGB")), shown)
    assert read_image(linear).shape == (*shown.shape[:2], 3)
    # The command line reads the same file.
    taken = read_edits(edits)
    assert {each["id"] for each in taken.lights or ()} == {"ceiling", "key", "point-1"}

    with visiting(browser, link) as visit:
        page = visit.page
        np.testing.assert_array_equal(settled(page), shown)
        assert page.get_by_label("Exposure").input_value() == "1"
        # What the link brought is one step.
        page.get_by_role("button", name="Reset", exact=True).first.click()
        assert np.abs(settled(page) - shown).mean() > 2

    with visiting(browser, address) as visit:
        page = visit.page
        settled(page)
        page.get_by_label("Edits to open").set_input_files(edits)
        page.get_by_label("Exposure").fill("1")
        np.testing.assert_array_equal(settled(page), shown)


@pytest.mark.parametrize(
    "hash_",
    [
        "nonsense",
        "%E0%A4%A",
        quote("[]"),
        quote(json.dumps({"scene": "nowhere", "method": "none", "exposure": "x"})),
        quote(json.dumps({"edits": {"lights": 3}})),
        quote(json.dumps({"edits": {"lights": [{"id": "new", "type": "no-such"}]}})),
    ],
)
def test_a_broken_link_leaves_the_scene_as_it_is(
    browser: Browser, address: str, visiting: Visiting, hash_: str
) -> None:
    with visiting(browser, address) as visit:
        own = settled(visit.page)
    with visiting(browser, f"{address}#{hash_}") as visit:
        page: Page = visit.page
        np.testing.assert_array_equal(settled(page), own)
        if "lights" in hash_:
            assert "cannot be taken up" in page.inner_text("#problem")
        assert pixels(page).shape == own.shape
