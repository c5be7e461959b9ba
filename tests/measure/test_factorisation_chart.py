"""The chart of BRDF fits: its numbers, its files, and whose materials the command takes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from engine.arguments import materials_of
from engine.brdf.diffuse import Diffuse
from engine.brdf.published import PUBLISHED, SKIN
from engine.cli import app
from engine.errors import InputError
from engine.measure.chart import write_figure
from engine.measure.factorisation_chart import draw, fit_document


def test_document_and_figure(tmp_path: Path) -> None:
    seen: list[tuple[str, int, int]] = []
    document = fit_document(
        {"skin": SKIN, "wall": Diffuse()},
        sizes=(8, 16),
        terms=8,
        pairs=2000,
        progress=lambda *step: seen.append(step),
    )
    skin, wall = document["materials"]
    for fit in skin["fits"]:
        assert len(fit["rms"]) == 8
        assert fit["rms"][7] < fit["rms"][0] < skin["rms_of_none"]
    assert skin["fits"][1]["rms"][7] < skin["fits"][0]["rms"][7]
    # One term of a diffuse material is exact.
    assert [len(fit["rms"]) for fit in wall["fits"]] == [1, 1]
    assert wall["fits"][0]["rms"][0] < 1e-7 * wall["rms_of_none"]
    assert [step[1:] for step in seen] == [(1, 4), (2, 4), (3, 4), (4, 4)]
    paths = write_figure(draw(document), document, tmp_path, "factorisation")
    assert [path.name for path in paths] == [f"factorisation.{k}" for k in ("svg", "png", "json")]
    assert json.loads(paths[2].read_text()) == json.loads(json.dumps(document))
    assert "terms K" in paths[0].read_text()


def test_whose_materials() -> None:
    assert materials_of(None) is PUBLISHED
    assert list(materials_of("knot")) == ["brushed"]
    with pytest.raises(InputError, match="one term is exact"):
        materials_of("cornell-box")


def test_other_charts_need_a_scene(tmp_path: Path) -> None:
    result = CliRunner().invoke(app, ["chart", "--out", str(tmp_path)])
    assert isinstance(result.exception, InputError)
    assert "of a scene, and of one" in str(result.exception)
