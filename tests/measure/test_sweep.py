"""Sweeps name their variants, references are kept, a benchmark can be printed."""

from __future__ import annotations

import io
from pathlib import Path

import numpy as np
import pytest
from rich.console import Console

from engine.errors import InputError, NotFound
from engine.measure import sweep as sweep_module
from engine.measure import truth as truth_module
from engine.measure.bench import bench
from engine.measure.bench_tables import bench_tables
from engine.measure.sweep import SWEEPS, time_frames, variants
from engine.measure.truth import truth
from engine.methods import METHODS
from engine.methods.base import Frame
from engine.scene.edits import Edits
from engine.scene.open import open_scene
from engine.store import Store


def test_every_swept_setting_exists() -> None:
    for method in SWEEPS:
        for knob, settings in variants(method, {})[1:]:
            assert getattr(settings, knob) in SWEEPS[method][knob]


def test_settings_are_swept_one_at_a_time_and_once() -> None:
    method = "direct_to_indirect"
    found = variants(method, {"bounces": 1}, {"coefficients": [25, 100, 400], "bounces": [1, 2]})
    defaults = METHODS[method].settings()
    assert [(knob, s.coefficients, s.bounces) for knob, s in found] == [
        ("", defaults.coefficients, 1),
        ("coefficients", 25, 1),
        ("coefficients", 400, 1),
        ("bounces", defaults.coefficients, 2),
    ]
    assert {s.gather_samples for _, s in found} == {defaults.gather_samples}


def test_of_several_methods_each_takes_the_settings_that_it_has() -> None:
    both = ["direct_to_indirect", "wavelet_brdf"]
    chosen = {"cells": 16, "coefficients": 25, "bounce": 1}
    # What nobody has stays, to be refused by name.
    assert sweep_module._known_to(both[0], both, chosen) == {"coefficients": 25, "bounce": 1}
    assert sweep_module._known_to(both[1], both, chosen) == {"cells": 16, "bounce": 1}


def test_a_sweep_of_what_is_not_there_is_refused() -> None:
    with pytest.raises(InputError, match="bounce: no such setting"):
        variants("direct_to_indirect", {}, {"bounce": [1]})
    with pytest.raises(NotFound, match="magic"):
        variants("magic", {})


class Steps:
    """A product that counts its frames."""

    method, settings, bytes = "steps", None, 0

    def __init__(self) -> None:
        self.asked: list[Edits] = []

    def relight(self, edits: Edits, scale: int = 1) -> Frame:
        self.asked.append(edits)
        return Frame(np.full((1, 1, 3), len(self.asked), np.float32), {"total": 0.001})


def test_no_timed_frame_can_be_remembered() -> None:
    """Pictures of lights that did not move are kept, so every timed edit is a new one."""
    place = {"id": "a", "type": "point", "position": (1.0, 2.0, 3.0)}
    edits = [Edits(lights=[place]), Edits(lights=[{"id": "b", "enabled": False}, place])]
    product = Steps()
    frames, timing, parts = time_frames(product, edits, repeats=3, step=0.5)
    assert product.asked[:2] == edits
    assert [frame.image[0, 0, 0] for frame in frames] == [1, 2]
    assert len(timing.seconds) == 6
    assert parts == {"total": 0.001}
    places = [[light.get("position") for light in e.lights or []] for e in product.asked]
    assert places[2::2] == [[(1.5, 2.0, 3.0)], [(2.0, 2.0, 3.0)], [(2.5, 2.0, 3.0)]]
    assert places[3::2] == [[None, *moved] for moved in places[2::2]]


def test_references_are_kept_and_told_apart(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = open_scene("cornell-box")
    scene = scene.with_camera(scene.camera.model_copy(update={"width": 8, "height": 8}))
    calls: list[float] = []
    render = truth_module.render

    def counted(*args: object, **options: object) -> object:
        calls.append(1.0)
        return render(*args, **options)  # type: ignore[arg-type]

    monkeypatch.setattr(truth_module, "render", counted)
    store, still = Store(tmp_path), Edits()
    dark = Edits(lights=[{"id": "key", "enabled": False}])
    first = truth(scene, still, 0.5, store)
    again = truth(scene, still, 0.5, store)
    assert len(calls) == 1
    assert np.array_equal(first.image, again.image)
    assert np.array_equal(first.variance, again.variance)
    assert (first.error, first.samples) == (again.error, again.samples)
    assert not np.array_equal(truth(scene, dark, 0.5, store).image, first.image)
    truth(scene, still, 0.4, store)
    moved = scene.camera.model_copy(update={"fov_y_degrees": 20.0})
    truth(scene.with_camera(moved), still, 0.5, store)
    assert len(calls) == 4
    # Light that is cut off is another picture, of which direct light alone is the darkest.
    direct = truth(scene, still, 0.5, store, max_bounces=1)
    assert len(calls) == 5
    assert direct.image.sum() < 0.9 * first.image.sum()
    assert np.array_equal(truth(scene, still, 0.5, store, max_bounces=1).image, direct.image)
    assert len(calls) == 5


def test_a_benchmark_is_complete_and_can_be_printed(tmp_path: Path) -> None:
    (tmp_path / "small.json").write_text(SMALL_SCENE)
    document = bench([open_scene(str(tmp_path / "small.json"))], changes={"gather_samples": 1024})
    (found,) = document["scenes"]
    assert found["scene"] == "small"
    assert found["bytes"] > 0
    assert found["phase_seconds"]
    assert 0.5 * found["precompute_seconds"] < sum(found["phase_seconds"].values())
    assert sum(found["phase_seconds"].values()) < 1.1 * found["precompute_seconds"]
    frame = found["frame_seconds"]
    assert 0 < frame["median"] <= frame["p95"]
    assert set(frame["lights"]) == {"a new spot light", "a new point light", "'lamp' moved"}
    assert min(frame["lights"].values()) <= frame["median"] <= max(frame["lights"].values())
    # Less than a frame reads in its own time, as a frame does more than that.
    rate = found["ratios"]["product_bandwidth"] * document["machine"]["memory_read_gb_s"] * 1e9
    assert rate > found["bytes"] / frame["median"]
    assert "rivals" not in found
    console = Console(width=100, file=io.StringIO())
    for table in bench_tables(document):
        console.print(table)
    printed = console.file.getvalue()  # type: ignore[attr-defined]
    for words in ("memory read", "small", "precompute", "MB", "reference / frame"):
        assert words in printed


SMALL_SCENE = """{
  "name": "small",
  "camera": {"position": [0, 1, 3], "target": [0, 0.5, 0], "width": 16, "height": 12},
  "lights": [{"id": "lamp", "type": "point", "position": [0, 2, 1], "intensity": [5, 5, 5]}],
  "materials": {"grey": {"type": "diffuse", "diffuse": [0.5, 0.5, 0.5]}},
  "objects": [
    {"name": "floor", "material": "grey", "mesh": {"shape": "polygons", "polygons":
      [[[-2, 0, 2], [2, 0, 2], [2, 0, -2], [-2, 0, -2]]]}},
    {"name": "wall", "material": "grey", "mesh": {"shape": "polygons", "polygons":
      [[[-2, 0, -2], [2, 0, -2], [2, 3, -2], [-2, 3, -2]]]}}
  ]
}"""
