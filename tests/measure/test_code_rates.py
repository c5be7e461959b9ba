"""Table 2 of `wavelet_brdf`, and what `relight bench` adds for it."""

from __future__ import annotations

from typing import Any

import pytest

from engine.backend.choice import chosen_device
from engine.errors import InputError
from engine.measure.bench import bench
from engine.measure.bench_codes import code_over_formula, sitting
from engine.measure.code_rates import LEVELS, MOVES, markdown, rates
from engine.measure.code_stage import lit, measured
from engine.measure.stage import ball
from engine.methods import prepare
from engine.methods.wavelet_brdf import Settings, Wavelets
from engine.methods.wavelet_brdf.settings import FILTERS
from engine.store import Store


@pytest.fixture(scope="module")
def document() -> dict[str, Any]:
    return rates(ball(8), (24, 20), {"cells": 8}, pairs=1 << 12)


def test_every_level_and_filter_is_timed(document: dict[str, Any]) -> None:
    rows = document["frames_per_second"]
    backends = ["cpu", *(["gl"] if document["gl"] else [])]
    found = [(row["backend"], row["filter"], row["level"]) for row in rows]
    assert sorted(found) == sorted(
        (b, f, k) for b in backends for f in FILTERS for k in range(LEVELS)
    )
    assert all(1 < row[move] < 1e6 for row in rows for move in MOVES)
    assert 0 < document["pixels_of_object"] < 24 * 20
    values = document["values_per_second"]
    assert list(values) == ["plastic", "brushed", "threads"]
    assert all(1e3 < number < 1e10 for each in values.values() for number in each.values())


def test_the_table_says_it(document: dict[str, Any]) -> None:
    lines = markdown(document)
    rows = [line for line in lines if line.startswith("| cpu | bilinear | light moved")]
    finest = next(
        row["light"]
        for row in document["frames_per_second"]
        if (row["backend"], row["filter"], row["level"]) == ("cpu", "bilinear", LEVELS - 1)
    )
    assert float(rows[0].split("|")[-2]) == pytest.approx(finest, rel=0.01)
    assert any("206 | 90 | 56 | 41 | 31" in line for line in lines)


def test_a_sitting_switches_materials_and_levels(tmp_path: Any) -> None:
    scene = lit(ball(8), measured("plastic"), (24, 20))
    settings = Settings(cells=8)
    product = prepare(scene, "wavelet_brdf", settings, store=Store(tmp_path))
    assert isinstance(product, Wavelets)
    found = sitting(product, scene, settings)
    assert found["another material, known"] < found["another material, new"]
    assert len([name for name in found if "level" in name]) == LEVELS
    assert code_over_formula() > 0.1


def test_a_benchmark_of_codes() -> None:
    """Judged on moved lights, and by a reference that reflects light once, as the method does."""
    scene = lit(ball(8), measured("plastic"), (24, 20))
    gl = chosen_device("gl")[0] is not None
    args = {"changes": {"cells": 8}, "method": "wavelet_brdf", "with_gl": gl}
    result = bench([scene], **args)["scenes"][0]
    assert "'key' moved" in result["frame_seconds"]["lights"]
    assert "another material, new" in result["frame_seconds"]["lights"]
    assert result["ratios"]["code_over_formula"] > 0.1
    assert result["ratios"]["reference_over_frame"] > 0
    assert set(result.get("gl", {})) == ({"an edit", "the camera moved"} if gl else set())
    for found in result.get("gl", {}).values():
        assert min(found["seconds"].values()) > 0
        assert 0 < found["apart"]["median"] <= found["apart"]["worst"] < 1e-2


def test_what_only_the_cpu_draws_is_not_compared() -> None:
    with pytest.raises(InputError, match="brdf_editing are drawn by the CPU alone"):
        bench([], method="brdf_editing", with_gl=True)
