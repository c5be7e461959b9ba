"""Scenes of one's own: chosen or dropped, shown, refused in words, removed."""

from __future__ import annotations

import base64
from typing import Any

import hostile
import pytest
from playwright.sync_api import Page

pytestmark = pytest.mark.web
DROP = """({name, data}) => {
  const bytes = Uint8Array.from(atob(data), (c) => c.charCodeAt(0));
  const transfer = new DataTransfer();
  transfer.items.add(new File([bytes], name));
  const fire = (kind) => document.body.dispatchEvent(
    new DragEvent(kind, { dataTransfer: transfer, bubbles: true, cancelable: true }));
  fire("dragover");
  const shown = !document.getElementById("scene-drop").hidden;
  fire("drop");
  return shown && document.getElementById("scene-drop").hidden;
}"""


def drop(page: Page, name: str, data: bytes) -> bool:
    """Whether the page says where to drop while the file is over it."""
    found: bool = page.evaluate(DROP, {"name": name, "data": base64.b64encode(data).decode()})
    return found


def test_a_scene_of_ones_own_is_opened_and_removed(visit: Any) -> None:
    page: Page = visit.page
    title = page.title()
    assert drop(page, "circle.glb", hostile.glb(*hostile.gltf(nodes__1__children=[1])))
    told = page.locator("#scene-told")
    told.filter(has_text="nodes go in a circle").wait_for(timeout=60_000)
    assert told.text_content() == ("circle.glb, nodes.1: is below itself: nodes go in a circle")
    visit.errors.clear()  # the browser notes that the service refused
    assert page.title() == title

    file = {"name": "my quad.glb", "mimeType": "", "buffer": hostile.glb(*hostile.gltf())}
    page.get_by_label("Scene to open").set_input_files(file)
    page.wait_for_function("() => document.title === 'my quad.glb · Relight'", timeout=60_000)
    chosen = page.get_by_role("radio", name="my quad.glb")
    assert chosen.get_attribute("aria-checked") == "true"
    assert told.text_content() == ""
    page.wait_for_function("() => document.getElementById('waiting').hidden")
    page.get_by_role("button", name="Remove my quad.glb").click()
    page.wait_for_function(f"() => document.title === '{title}'")
    assert chosen.count() == 0
