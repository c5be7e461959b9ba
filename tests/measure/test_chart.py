"""The chart shows every point, and its JSON is complete."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from PIL import Image

from engine.measure.chart import draw, write_chart
from engine.measure.document import finite, provenance
from engine.measure.points import COSTS, Point, pareto_front
from engine.measure.timing import Timing


def point(milliseconds: float, error: float, size: int = 0) -> Point:
    timing = Timing((milliseconds / 1000,))
    return Point("m", "k", {}, {"relative_l2": error}, [], timing, {}, size, 0.0, [])


def test_the_front_holds_what_nothing_beats() -> None:
    points = [
        point(t, e) for t, e in [(3, 0.1), (1, 0.5), (2, 0.3), (2.5, 0.4), (4, 0.1), (2, 0.2)]
    ]
    assert pareto_front(points) == [1, 5, 0]
    assert pareto_front(points[:1]) == [0]


def test_bytes_have_a_front_of_their_own() -> None:
    points = [point(t, e, size) for t, e, size in [(1, 0.1, 30), (2, 0.2, 10), (3, 0.3, 20)]]
    assert pareto_front(points) == [0]
    assert pareto_front(points, "bytes") == [1, 0]


@pytest.mark.parametrize("seed", range(5))
def test_the_front_by_its_definition(seed: int) -> None:
    pairs = np.random.default_rng(seed).integers(1, 12, (30, 2))
    points = [point(t, e) for t, e in pairs]
    front = {(points[k].frame.median, points[k].error["relative_l2"]) for k in pareto_front(points)}

    def beaten(t: float, e: float) -> bool:
        return any(t2 <= t and e2 <= e and (t2, e2) != (t, e) for t2, e2 in pairs)

    assert front == {(t / 1000, e) for t, e in pairs if not beaten(t, e)}


def document() -> dict[str, Any]:
    defaults = {"coefficients": 100, "gather_samples": 65536, "gather": "rays"}
    rows = [("", {}, 40, 0.03), ("coefficients", {"coefficients": 25}, 15, 0.08)]
    rows += [("coefficients", {"coefficients": 400}, 120, 0.02)]
    rows += [("gather_samples", {"gather_samples": 4096}, 30, 0.06)]
    rows += [("gather", {"gather": "links"}, 40, 0.05)]
    return {
        **provenance(),
        "machine": {"cpu": "a machine", "threads": 2, "memory_read_gb_s": 8.0},
        "scene": "cornell-box",
        "width": 512,
        "height": 512,
        "seed": 1,
        "main_error": "relative_l2",
        "edits": [{}, {}],
        "references": [{"floor": 0.01}, {"floor": 0.01}],
        "points": [
            {
                "method": "direct_to_indirect",
                "knob": knob,
                "settings": {**defaults, **changes},
                "fronts": list(COSTS) if error < 0.05 else [],
                "error": {"relative_l2": error},
                "frame_seconds": {"median": ms / 1000},
                "bytes": 1e6 * ms,
                "precompute_seconds": float(ms),
            }
            for knob, changes, ms, error in rows
        ],
        "others": [
            {
                "method": "path tracer",
                "knob": "samples",
                "settings": {"samples": n},
                "error": {"relative_l2": n**-0.5},
                "frame_seconds": {"median": 0.1 * n},
            }
            for n in (1, 4, 16)
        ],
    }


def test_the_files_of_a_chart(tmp_path: Path) -> None:
    numbers = document()
    paths = write_chart(numbers, tmp_path / "out")
    assert [path.name for path in paths] == ["chart.svg", "chart.png", "chart.json"]
    assert json.loads(paths[2].read_text()) == document() | {
        "date": json.loads(paths[2].read_text())["date"]
    }
    with Image.open(paths[1]) as image:
        pixels = np.asarray(image.convert("RGB"))
    assert pixels.shape[1] >= 1500
    # All lines are there, in their colours.
    for colour in ((0x00, 0x72, 0xB2), (0xD5, 0x5E, 0x00), (0x00, 0x9E, 0x73)):
        assert (pixels == colour).all(axis=2).sum() > 200
    texts = "".join(ElementTree.parse(paths[0]).getroot().itertext())
    for words in (
        "coefficients = 400",
        "gather_samples = 4K",
        "gather = links",
        "defaults",
        "25",
        "Pareto front",
        "noise of the references",
        "cornell-box",
        "a machine",
        "path tracer, 1 sample",
        "transport (MB)",
        "precompute (s)",
    ):
        assert words in texts


def test_labels_do_not_cover_each_other(tmp_path: Path) -> None:
    """Ten settings that all but coincide, words among them."""
    numbers = document()
    words = numbers["points"][-1]
    crowd = [
        {**words, "knob": f"setting_{k}", "settings": {**words["settings"], f"setting_{k}": "much"}}
        for k in range(9)
    ]
    numbers["points"] += crowd
    for point in numbers["points"][:-9]:
        point["settings"] |= {f"setting_{k}": "little" for k in range(9)}
    figure = draw(numbers)
    figure.draw_without_rendering()
    boxes = [
        text.get_window_extent()
        for text in figure.axes[0].texts
        if "=" in text.get_text() or text.get_text() == "defaults"
    ]
    assert len(boxes) == 13
    for k, box in enumerate(boxes):
        assert not any(box.overlaps(other) for other in boxes[:k])


def test_the_same_numbers_give_the_same_files(tmp_path: Path) -> None:
    numbers = document()
    first, second = (write_chart(numbers, tmp_path / name) for name in "ab")
    assert [p.read_bytes() for p in first] == [p.read_bytes() for p in second]


def test_a_single_point_can_be_drawn(tmp_path: Path) -> None:
    numbers = document()
    del numbers["points"][1:]
    assert all(path.stat().st_size > 0 for path in write_chart(numbers, tmp_path))


def test_what_json_has_not_becomes_null() -> None:
    value = {"a": [1.5, float("inf"), (float("nan"), 2)], "b": "inf"}
    assert finite(value) == {"a": [1.5, None, [None, 2]], "b": "inf"}
