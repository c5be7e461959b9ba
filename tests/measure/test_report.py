"""The report: one file that needs no other, from documents that are measured once."""

from __future__ import annotations

import json
from html.parser import HTMLParser
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from engine.measure import report
from engine.measure.papers import ERROR, FRAME, PAPERS
from engine.measure.report import write_report
from engine.measure.report_page import page
from engine.methods import METHODS
from engine.methods.base import silent

MACHINE = {"cpu": "a <machine>", "threads": 2, "memory_read_gb_s": 8.0, "random_rays_m_s": 3.0}


def survey_of(scene: str, kinds: list[str], budget: float, error: float) -> dict[str, Any]:
    def point(knob: str, settings: dict[str, Any], ms: float, off: float) -> dict[str, Any]:
        return {
            "method": "glossy_prt", "knob": knob, "settings": settings,
            "fronts": ["frame_seconds", "bytes", "precompute_seconds"],
            "error": {"relative_l2": off}, "frame_seconds": {"median": ms / 1000},
            "bytes": 1e6 * ms, "precompute_seconds": ms,
        }  # fmt: skip

    cost = {"error": 0.04, "frame": 0.02, "bytes": 2e6, "precompute": 30.0}
    return {
        "scene": scene, "kinds": kinds, "width": 192, "height": 144, "machine": MACHINE,
        "date": "2026-01-01T00:00:00", "commit": "abc", "seed": 1, "main_error": "relative_l2",
        "edits": [{}], "references": [{"floor": 0.005}], "others": [],
        "points": [point("plan", {}, 20, error)]
        + [point("rung", {"rung": k}, 10 * (k + 1), 0.1 / (k + 1)) for k in range(3)],
        "plan": {
            "method": "glossy_prt", "budget": budget, "predicted": cost, "seconds": 3.0,
            "measured": {**cost, "error": error}, "holds": True, "kept": error <= budget,
            "best_swept_frame": 0.019, "reasons": ["terms = 2: 1 would be 9 % off"],
            "left_out": ["brdf_editing takes no edits of environment"],
        },
    }  # fmt: skip


def against() -> dict[str, Any]:
    row = {
        "method": "glossy_prt", "name": "bunny", "machine": "Pentium", "scene": "knot",
        "settings": {"terms": 4}, "theirs": {FRAME: 208.0, ERROR: 5.4}, "ours": {FRAME: 20.0},
    }  # fmt: skip
    return {"machine": MACHINE, "rows": [row]}


def regimes() -> dict[str, Any]:
    row = {
        "group": "lights", "name": "lamp in a wall", "method": "glossy_prt", "words": "A & B.",
        "error": 0.3, "floor": 0.01, "bound": 0.4, "warnings": {"lights_left_out": 0.2},
        "mend": None, "mended_error": None,
    }  # fmt: skip
    counts = {"false_alarms": [], "overstated": [], "silent": ["lamp <1>"]}
    return {"counts": counts, "budget": 0.05, "overstated_from": 3, "regimes": [row]}


class Page(HTMLParser):
    """Every tag is closed, and every address is within the page."""

    VOID = frozenset({"meta", "img"})

    def __init__(self, text: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.addresses: list[str] = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        if tag not in self.VOID:
            self.open.append(tag)
        self.addresses += [value or "" for name, value in attrs if name in ("src", "href")]

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_the_page_holds_everything_and_needs_nothing() -> None:
    surveys = [
        survey_of("knot", ["environment"], 0.05, 0.03), survey_of("vase", ["camera"], 0.05, 0.06)
    ]  # fmt: skip
    text = page(surveys, [b"<svg/>"] * 2, against(), regimes(), {"lights": b"png"})
    parsed = Page(text)
    assert not parsed.open
    assert [a.split(",")[0] for a in parsed.addresses] == [
        *["data:image/svg+xml;base64"] * 2, "data:image/png;base64",
    ]  # fmt: skip
    assert "Above 5 % and silent: 1 (lamp &lt;1&gt;)" in text
    assert "<code>lights_left_out</code> 20 %" in text
    assert "a &lt;machine&gt;" in text
    assert ">yes<" in text
    assert 'class="words">environment' in text
    assert ">NO<" in text, "a budget that was promised and broken stands out"
    assert "<td>208</td><td>20</td><td>5.4</td><td>–</td>" in text
    assert "left out: brdf_editing takes no edits of environment" in text
    assert text == page(surveys, [b"<svg/>"] * 2, against(), regimes(), {"lights": b"png"})


def test_what_was_measured_is_not_measured_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[str, ...]] = []

    def plan(scene: Any, kinds: Any, budget: float, **_: Any) -> SimpleNamespace:
        asked.append((scene.name, *kinds, budget))
        assert max(scene.camera.width, scene.camera.height) == report.SIDE
        return SimpleNamespace(kinds=kinds, budget=budget, holds=budget > 0.05)

    def survey(scene: Any, planned: Any, **_: Any) -> dict[str, Any]:
        return survey_of(scene.name, list(planned.kinds), planned.budget, 0.07)

    monkeypatch.setattr(report, "plan", plan)
    monkeypatch.setattr(report, "survey", survey)

    def chart(methods: Any, side: int, folder: Path, progress: Any) -> None:
        (folder / "stability.json").write_text(json.dumps(regimes()))
        for group in report.GROUPS:
            (folder / report.stability.sheet_name(group)).write_bytes(b"png")

    monkeypatch.setattr(report.stability, "chart", chart)
    monkeypatch.setattr(report.papers, "compare", lambda progress: against())
    paths = write_report(["cornell-box"], tmp_path, rivals=False, progress=silent)
    assert paths[0].name == "report.html"
    # What nothing holds is planned for with more.
    assert asked == [
        ("cornell-box", kind, budget) for kind in ("lights", "materials") for budget in (0.05, 0.1)
    ]
    text = paths[0].read_text()
    assert json.loads((tmp_path / "cornell-box-lights.json").read_text())["plan"]["budget"] == 0.1
    write_report(["cornell-box"], tmp_path, rivals=False, progress=silent)
    assert len(asked) == 4
    assert paths[0].read_text() == text


def test_every_method_stands_beside_its_paper() -> None:
    assert {case.method for case in PAPERS} == set(METHODS)
    for case in PAPERS:
        assert case.kind in METHODS[case.method].edits
