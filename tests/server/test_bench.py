"""`relight bench --service`: its table, and all of it once."""

from __future__ import annotations

import json
import subprocess
import sys
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

from server.bench import _of_memory, _transport
from server.bench_table import lines, rows

FLAT = {"memory_mb": 300.0, "memory_end_mb": 301.0, "memory_most_mb": 302.0, "mb_per_minute": 0.1}
TRANSPORT = {"width": 512, "height": 512, "over_p95_ms": 5.0}
DOCUMENT: dict[str, Any] = {
    "scene": "box",
    "cores": 2,
    "start": {"listening": 1.0, "first_pixels": 1.5, "with_product": 2.0},
    "transport": {"socket": {**TRANSPORT}, "request": {**TRANSPORT}},
    "clients": {
        "frames": [50] * 16, "per_second": 40.0, "slowest_over_mean": 0.9, "answer_p95_ms": 300.0,
        "stale": 0, "errors": [], **FLAT,
    },
    "stopped": {
        "reading": {
            "dropped_after_s": 16.0, "per_second": 40.0, "per_second_beside": 39.0, "stale": 0,
            "errors": [], **FLAT,
        },
    },
}  # fmt: skip


@pytest.mark.parametrize(
    ("place", "value", "words"),
    [
        ("transport.request.over_p95_ms", 9.0, "request, p95"),
        ("clients.slowest_over_mean", 0.4, "slowest over mean"),
        ("clients.memory_end_mb", 320.0, "memory"),
        ("clients.stale", 1, "stale"),
        ("clients.errors", ["it broke"], "errors"),
        ("stopped.reading.dropped_after_s", None, "dropped after"),
        ("stopped.reading.dropped_after_s", 21.0, "dropped after"),
        ("stopped.reading.per_second_beside", 20.0, "rate of the others"),
        ("start.first_pixels", 3.5, "first pixels"),
    ],
)
def test_what_is_missed_is_said(place: str, value: Any, words: str) -> None:
    assert all(holds for *_, holds in rows(DOCUMENT))
    document = deepcopy(DOCUMENT)
    *path, last = place.split(".")
    part = document
    for key in path:
        part = part[key]
    part[last] = value
    (missed,) = [line for line in lines(document) if line.endswith("MISSED")]
    assert words in missed


def test_transport_is_what_is_not_drawing() -> None:
    timings = {"buffer": 1.0, "relight": 20.0, "encode": 2.0}
    frames = [(0.025 + 1e-4 * k, {"timings": timings, "width": 8, "height": 6}) for k in range(101)]
    found = _transport(frames)
    assert found["draw_median_ms"] == 21
    assert found["over_median_ms"] == pytest.approx(9.0, abs=0.01)
    assert found["over_p95_ms"] == pytest.approx(13.5, abs=0.11)


def test_memory_that_grows_has_a_slope() -> None:
    found = _of_memory([(t, 100.0 + t / 6) for t in range(120)])
    assert found["mb_per_minute"] == pytest.approx(10)
    assert found["memory_most_mb"] == found["memory_end_mb"] == pytest.approx(119.8, abs=0.1)
    assert _of_memory([])["memory_mb"] is None


@pytest.mark.sweep
def test_all_of_it(tiny_scene: Path) -> None:
    """On a scene so small that what is measured is the service."""
    command = [sys.executable, "-m", "engine.cli", "bench", str(tiny_scene), "--service", "--json"]
    run = subprocess.run([*command, "--seconds", "20"], check=True, capture_output=True, text=True)
    document = json.loads(run.stdout)
    assert len(document["clients"]["frames"]) == 16
    # What hangs on the machine is left out, such as how long it takes to start.
    missed = [what for what, _, _, holds in rows(document) if not holds]
    assert [what for what in missed if "start" not in what and "transport" not in what] == []
