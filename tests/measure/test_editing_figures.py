"""Figures of `brdf_editing`: what the paper says of each is true of ours."""

from __future__ import annotations

from dataclasses import replace

import pytest

from engine.measure.editing_figures import FIGURES
from engine.measure.editing_session import Session
from engine.store import Store

FIXED = {"gather_samples": 4096, "view_rays": 128}


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Session:
    store = Store(tmp_path_factory.mktemp("store"))
    return Session(width=32, fixed=FIXED, reference_error=0.15, store=store)


def numbers(session: Session, figure: int, metric: str) -> dict[tuple[str, str], float]:
    sheet = FIGURES[figure](session)
    assert len({len(row.tiles) for row in sheet.rows}) == 1
    assert sheet.document["figure"] == figure
    return {(p["edit"], p["title"]): p[metric] for p in sheet.document["pictures"]}


@pytest.mark.sweep
def test_the_box_is_edited_and_coarser_ways_are_worse(session: Session) -> None:
    full, matt, direct = numbers(session, 7, "flip").values()
    assert full < matt < direct
    # Six of them are light after the fourth bounce.
    assert max(numbers(session, 6, "relative_l2").values()) < 0.12


@pytest.mark.sweep
def test_caustics_need_gloss_behind_the_first_bounce(session: Session) -> None:
    # Large pixels have few rays for so narrow a light.
    finer = replace(session, width=96, fixed={"gather_samples": 16384}, reference_error=0.3)
    caustics = numbers(finer, 11, "relative_l2")
    for name in ("as it is", "a glossy plane"):
        assert caustics[name, "(64, 16)"] < caustics[name, "(64, 1)"]


def test_figures_have_makers() -> None:
    assert sorted(FIGURES) == [1, 4, 6, 7, 9, 11, 12]


@pytest.mark.sweep
def test_figures_are_charted(session: Session) -> None:
    found = numbers(session, 9, "relative_l2")
    assert max(found.values()) < 0.3
