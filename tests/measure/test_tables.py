"""Tables I and II: what is counted, and that the tables say what the numbers say."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from engine.brdf.published import BRUSHED
from engine.measure.stage import ball, knot, stage
from engine.measure.tables import PAPER, profiles, write
from engine.methods import prepare
from engine.methods.glossy_prt import Settings
from engine.store import Store

pytestmark = pytest.mark.sweep

FIXED = {"light_texels": 16, "visibility_texels": 16, "gather_texels": 8, "brdf_texels": 16}
CUTS = 8


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    return profiles([ball(6), knot(48, 8)], size=(32, 24), cuts=CUTS, fixed=FIXED)


def test_what_is_counted(document: dict[str, Any], tmp_path: Path) -> None:
    small, large = document["objects"]
    assert (small["name"], large["name"]) == ("ball", "knot")
    assert (small["vertices"], large["vertices"]) == (7 * 13, 49 * 9)
    assert (small["triangles"], large["triangles"]) == (2 * 12 * 6 - 2 * 12, 2 * 48 * 8)
    assert small["floor_vertices"] == large["floor_vertices"] == (CUTS + 1) ** 2
    for entry in document["objects"]:
        one, four = entry["terms"]["1"], entry["terms"]["4"]
        for profile in (one, four):
            assert profile["bytes"] > profile["direct_bytes"] > 0
            assert profile["direct_seconds"] > 0
            assert profile["bounce_seconds"] > 0
            # Pictures this small take less than a twentieth of a second, and more than none.
            assert 20 < profile["view_fps"] < 1e5
            assert 20 < profile["light_fps"] < 1e5
        assert four["direct_bytes"] > 1.2 * one["direct_bytes"]
    assert large["terms"]["4"]["bytes"] > 1.5 * small["terms"]["4"]["bytes"]
    scene = stage(knot(48, 8), BRUSHED, (32, 24), cuts=CUTS)
    settings = Settings(**FIXED, bounces=1)
    made = prepare(scene, "glossy_prt", settings, store=Store(tmp_path))
    assert made.bytes == large["terms"]["4"]["bytes"]


def test_tables_say_what_the_numbers_say(document: dict[str, Any], tmp_path: Path) -> None:
    paths = write(document, tmp_path)
    assert [path.name for path in paths] == ["tables.json", "tables.md"]
    assert json.loads(paths[0].read_text()) == json.loads(json.dumps(document))
    lines = paths[1].read_text().splitlines()
    cells = {line.split("|")[1].strip(): line.split("|")[2:-1] for line in lines if "|" in line}
    told = [float(cell.removesuffix(" MB ")) for cell in cells["size of both, K = 4"]]
    true = [1e-6 * entry["terms"]["4"]["bytes"] for entry in document["objects"]]
    assert told == pytest.approx(true, abs=0.051)
    assert [cell.strip() for cell in cells["vertices of the floor"]] == ["81", "81"]
    # The paper's are beside them, with its machine.
    assert any(PAPER["machine"] in line for line in lines)
    assert "46 min" in cells["bounce, K = 4"][1]
    assert {len(cells[label]) for label in PAPER["rows"]} == {len(PAPER["objects"])}
