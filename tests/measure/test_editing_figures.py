"""Figures of `brdf_editing`: what the paper says of each is true of ours."""

from __future__ import annotations

from pathlib import Path

import pytest

from engine.measure.editing_figures import FIGURES
from engine.measure.editing_session import Session
from engine.store import Store

FIXED = {"gather_samples": 4096, "view_rays": 128}


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    store = Store(tmp_path_factory.mktemp("store"))
    return Session(width=32, fixed=FIXED, reference_error=0.15, store=store)


def numbers(session: Session, figure: int) -> dict[tuple[str, str], float]:
    sheet = FIGURES[figure](session)
    assert len({len(row.tiles) for row in sheet.rows}) == 1
    assert sheet.document["figure"] == figure
    return {(p["edit"], p["title"]): p["relative_l2"] for p in sheet.document["pictures"]}


def test_the_box_is_edited_and_coarser_ways_are_worse(session: Session) -> None:
    found = numbers(session, 7)
    full, matt, direct = found.values()
    assert full < 0.08
    assert full < matt < direct
    edits = numbers(session, 6)
    assert max(edits.values()) < 0.08
    assert edits["glossy wall", "(64, 1, 1, 1)"] == pytest.approx(full, abs=0.002)


def test_a_series_with_gloss_behind_is_nearer(session: Session) -> None:
    found = numbers(session, 4)
    assert found["teatray", "(128, 8)"] < found["teatray", "(128, 1)"]
    assert found["teatray", "direct light alone"] > found["teatray", "(128, 1)"]
    caustics = numbers(session, 11)
    for name in ("as it is", "a glossy plane"):
        assert caustics[name, "(64, 16)"] < caustics[name, "(64, 1)"]


def test_figures_are_charted(tmp_path: Path, session: Session) -> None:
    """Every figure has a maker, and each says which it is."""
    assert sorted(FIGURES) == [1, 4, 6, 7, 9, 11, 12]
    found = numbers(session, 9)
    assert max(found.values()) < 0.3
