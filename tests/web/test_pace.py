"""Which frames are asked for: the machine of `web/pace.js`, without a service."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any
from urllib.parse import quote

import pytest
from playwright.sync_api import Browser, Page

from engine.resources import resource

RUN = """async ([source, events]) => {
  const { Pace, STOP_MS, FINAL_MS, BUDGET_MS } = await import(source);
  const pace = new Pace();
  const said = [];
  for (const [name, ...values] of events) {
    const answer = pace[name](...values.map((v) => (v === "budget" ? BUDGET_MS : v)));
    if (answer === undefined) continue;
    const { request, wait } = answer;
    const waits = { [STOP_MS]: "stop", [FINAL_MS]: "final", [FINAL_MS - STOP_MS]: "rest" };
    said.push([pace.state, request.format ?? `1:${request.scale}`, waits[wait] ?? wait]);
  }
  return said;
}"""

MOVING, LET_GO, WAITED = ["changed", True], ["changed", False], ["waited"]
DEAR = ["changed", True, True]

Said = list[list[str | None]]


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    page = browser.new_page()
    yield page
    page.close()


def run(page: Page, *events: list[Any]) -> Said:
    """(state, request, wait) after every event."""
    source = "data:text/javascript," + quote((resource("web") / "pace.js").read_text())
    said: Said = page.evaluate(RUN, [source, list(events)])
    return said


def test_a_drag_from_its_first_move_to_the_lossless_frame(page: Page) -> None:
    half = ["moving", "1:2", "stop"]
    assert run(page, MOVING, MOVING, WAITED, MOVING, LET_GO, WAITED) == [
        half,
        half,
        ["resting", "1:1", "rest"],  # the hand is down and has stopped
        half,
        ["resting", "1:1", "final"],
        ["final", "png", None],
    ]


def test_a_change_without_a_hand_is_full_at_once(page: Page) -> None:
    assert run(page, LET_GO, LET_GO, WAITED, LET_GO) == [
        ["resting", "1:1", "final"],
        ["resting", "1:1", "final"],
        ["final", "png", None],
        ["resting", "1:1", "final"],
    ]


def test_frames_are_full_while_moving_if_all_of_the_last_ones_fit(page: Page) -> None:
    def last(said: Said) -> str | None:
        return said[-1][1]

    fits, slow = ["took", "budget"], ["took", 1000]
    assert last(run(page, fits, MOVING)) == "1:1"
    assert last(run(page, slow, MOVING)) == "1:2"
    assert last(run(page, fits, slow, fits, fits, MOVING)) == "1:2"
    assert last(run(page, slow, fits, fits, fits, MOVING)) == "1:1"
    assert last(run(page, fits, ["forget"], MOVING)) == "1:2"
    # A frame that turns out slow is the last full one of its drag.
    assert [s[1] for s in run(page, fits, MOVING, slow, MOVING)] == ["1:1", "1:2"]


def test_what_starts_work_of_its_own_waits_for_the_hand_to_let_go(page: Page) -> None:
    fits = ["took", "budget"]
    assert run(page, fits, DEAR, DEAR, LET_GO) == [
        ["moving", "1:2", None],
        ["moving", "1:2", None],
        ["resting", "1:1", "final"],
    ]
