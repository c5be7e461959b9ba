"""Figures 3, 8, 9 and 10 of `wavelet_brdf`: what the paper says of each is true of ours."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from engine.measure.code_figures import FIGURES, Shoot
from engine.measure.code_stage import measured_by_name
from engine.measure.contact_sheet import Sheet, draw
from engine.measure.stage import ball, knot


@pytest.fixture(scope="module")
def shoot() -> Shoot:
    return Shoot(ball(24), measured_by_name(["plastic"]), (48, 48))


def made(shoot: Shoot, figure: int) -> tuple[Sheet, list[dict[str, Any]]]:
    sheet = FIGURES[figure](shoot)
    assert sheet.document["figure"] == figure
    draw(sheet)
    return sheet, sheet.document["pictures"]


@pytest.mark.sweep
def test_from_afar_levels_are_nearer_than_the_finest(shoot: Shoot) -> None:
    _, found = made(replace(shoot, thing=knot(120, 16)), 3)
    off = {p["detail"]: p["relative_l2"] for p in found if p["picture"] == "plastic, n = 200"}
    assert off["by distance"] < 0.9 * off["finest"]


def test_a_code_is_nearer_than_a_formula_at_vertices(shoot: Shoot) -> None:
    sheet, found = made(shoot, 8)
    off = {p["by"]: p["lab"] for p in found}
    assert off["code"] < 0.6 * off["formula at vertices"]
    assert [len(row.tiles) for row in sheet.rows] == [1, 3, 3]


def test_what_the_eye_cannot_tell(shoot: Shoot) -> None:
    """Less than 1 in L*a*b*, which the paper names as the threshold."""
    _, found = made(shoot, 9)
    assert found[0]["lab"] < 1.0
    assert abs(found[0]["light"] - 1) < 0.02


@pytest.mark.sweep
def test_a_terrain(shoot: Shoot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("engine.measure.code_figures.SPEED", (32, 32))
    monkeypatch.setattr("engine.measure.code_figures.GRID", 2)
    sheet, found = made(shoot, 10)
    assert [p["detail"] for p in found[:3]] == ["finest", "by distance", "by footprint"]
    assert len(found) == 3 * 3 + 1
    assert len(found[-1]["frames_per_second"]) == 5
    # The finest level is blue wherever the terrain is, coarser ones are not.
    finest, distance, _, _ = sheet.rows[1].tiles
    assert finest is not None
    assert distance is not None
    assert set(map(tuple, finest.image.reshape(-1, 3).round(2))) == {
        (0.0, 0.0, 0.0),
        (0.0, 0.1, 1.0),
    }
    assert distance.image[..., 1].max() > 0.5
