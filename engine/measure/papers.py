"""The figures of the four papers beside ours, at their settings and picture sizes, on this machine.

Scenes are ours: as near as a built-in one comes to the paper's. Papers give frames per second; here
all are milliseconds, and sizes megabytes.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from engine.measure.code_stage import lit, measured, small_knot
from engine.measure.document import finite, provenance
from engine.measure.held_out import HELD_OUT
from engine.measure.machine import this_machine
from engine.measure.points import MAIN_ERROR
from engine.measure.settings import settings_from
from engine.measure.sweep import REFERENCE_ERROR, measure
from engine.measure.trial import Trial, trial_of
from engine.methods import METHODS
from engine.methods.base import Progress, silent
from engine.scene.edits import edited_camera
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.store import Store

EDITS, SEED = 4, 1
FRAME, PRECOMPUTE, SIZE, ERROR = "frame (ms)", "precompute (s)", "transport (MB)", "error (%)"


@dataclass(frozen=True)
class Comparison:
    """What a paper reports, and what of ours stands beside it.

    name      of the paper's case
    machine   that the paper used
    scene     of ours
    size      pixels of the picture
    kind      of edits
    settings  in place of defaults
    theirs    by what it counts: FRAME, PRECOMPUTE, SIZE, ERROR
    """

    method: str
    name: str
    machine: str
    scene: Callable[[], Scene]
    size: tuple[int, int]
    kind: str
    settings: Mapping[str, Any]
    theirs: Mapping[str, float]


def _built_in(name: str) -> Callable[[], Scene]:
    return lambda: open_scene(name)


def _mapped(name: str) -> Callable[[], Scene]:
    """A scene with its lamps off: its map alone shines."""
    return lambda: open_scene(name).with_lights(())


def _coded(material: str) -> Callable[[], Scene]:
    return lambda: lit(small_knot(), measured(material), (512, 512))


PENTIUM, XEON = "Pentium 4, 3.2 GHz, GeForce 7800", "Xeon, 3.2 GHz"
PAPERS: tuple[Comparison, ...] = (
    Comparison(
        "direct_to_indirect", "Sponza, spot light (table 2)", PENTIUM, _built_in("room"),
        (640, 480), "lights", {},
        {FRAME: 43.0, PRECOMPUTE: 4320.0, SIZE: 95.0, ERROR: 5.4},
    ),
    Comparison(
        "glossy_prt", "bunny, 4 terms, light moved (tables 1, 2)",
        "Pentium 4, 2.4 GHz, GeForce 6800", _mapped("knot"), (512, 512), "environment", {},
        {FRAME: 208.0, PRECOMPUTE: 3600.0, SIZE: 100.0},
    ),
    Comparison(
        "glossy_prt", "bunny, 4 terms, view moved (tables 1, 2)",
        "Pentium 4, 2.4 GHz, GeForce 6800", _mapped("knot"), (512, 512), "camera", {},
        {FRAME: 10.3, PRECOMPUTE: 3600.0, SIZE: 100.0},
    ),
    Comparison(
        "brdf_editing", "Cornell box, (64, 1, 1, 1) (table II)", XEON, _built_in("cornell-box"),
        (450, 450), "materials", {}, {FRAME: 45.5, PRECOMPUTE: 21480.0, SIZE: 1461.0},
    ),
    Comparison(
        "brdf_editing", "room, (64, 1, 1) (table II)", XEON, _built_in("room"),
        (640, 480), "materials", {"bounces": 2}, {FRAME: 50.0, PRECOMPUTE: 33900.0, SIZE: 755.0},
    ),
    Comparison(
        "brdf_editing", "teatrays, (128, 8, 1) (table II)", XEON, _built_in("teatray"),
        (320, 240), "materials", {"bands": 128, "second_bands": 8, "bounces": 2},
        {FRAME: 200.0, PRECOMPUTE: 7800.0, SIZE: 896.0},
    ),
    Comparison(
        "brdf_editing", "ring, (64, 16) (table II)", XEON, _built_in("ring"),
        (400, 400), "materials", {"second_bands": 16, "bounces": 1},
        {FRAME: 166.7, PRECOMPUTE: 22500.0, SIZE: 627.0},
    ),
    Comparison(
        "brdf_editing", "vase, (64, 1, 1, 1) (table II)", XEON, _built_in("vase"),
        (512, 512), "materials", {}, {FRAME: 52.6, PRECOMPUTE: 19740.0, SIZE: 964.0},
    ),
    Comparison(
        "wavelet_brdf", "fabric, level 0, bilinear (table 2)", "GeForce 7800 GTX",
        _coded("brushed"), (512, 512), "lights", {"level": 0.0, "detail": "finest"},
        {FRAME: 4.9},
    ),
)  # fmt: skip
"""All of them; precomputes of several passes are summed."""


def compare(
    papers: tuple[Comparison, ...] = PAPERS,
    store: Store | None = None,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Ours of every case, as JSON."""
    rows = []
    for number, case in enumerate(papers):
        progress("papers", number, len(papers))
        rows.append(_row(case, store or Store(), progress))
    progress("papers", len(papers), len(papers))
    return finite({**provenance(), "machine": this_machine().as_dict(), "rows": rows})


def _row(case: Comparison, store: Store, progress: Progress) -> dict[str, Any]:
    scene = case.scene()
    width, height = case.size
    scene = scene.with_camera(edited_camera(scene.camera, {"width": width, "height": height}))
    edits = HELD_OUT[case.kind](scene, EDITS, SEED)
    trial = Trial(scene, edits, [], [], [], [])
    if ERROR in case.theirs:
        trial = trial_of(scene, edits, REFERENCE_ERROR, store, progress)
    settings = settings_from(METHODS[case.method].settings, case.settings)
    point = measure(trial, case.method, "", settings, progress)
    ours = {
        FRAME: 1e3 * point.frame.median,
        PRECOMPUTE: point.precompute,
        SIZE: 1e-6 * point.bytes,
    }
    if ERROR in case.theirs:
        ours[ERROR] = 100 * point.error[MAIN_ERROR]
    return {
        "method": case.method,
        "name": case.name,
        "machine": case.machine,
        "scene": f"{scene.name}, {width} x {height}",
        "settings": dict(case.settings),
        "theirs": dict(case.theirs),
        "ours": ours,
    }
