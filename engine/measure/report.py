"""One page that says how fast and how exact everything is: measured here, told by `report_page`.

A part that was measured before is read from the folder: what takes long is done once, and an
interrupted report goes on where it stopped. Delete a file to have it measured anew.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from engine.measure import papers, stability
from engine.measure.chart import as_svg, draw
from engine.measure.document import write_json
from engine.measure.planner import plan
from engine.measure.regimes import GROUPS
from engine.measure.report_page import page
from engine.measure.survey import kinds_of, survey
from engine.methods.base import Progress
from engine.scene.edits import edited_camera
from engine.scene.open import open_scene
from engine.scene.scene import Scene

SCENES = ("cornell-box", "room", "teatray", "knot", "vase", "ring")
SIDE = 128  # pixels along the longer side of a survey's pictures
BUDGETS = (0.05, 0.1, 0.2)  # the first that anything holds is planned for


def write_report(
    scenes: Sequence[str], folder: Path, *, rivals: bool, progress: Progress
) -> list[Path]:
    """Measure what is missing and write report.html; returns the files of the folder.

    scenes  names or files, SCENES for none
    rivals  whether Mitsuba 3 stands beside
    """
    folder.mkdir(parents=True, exist_ok=True)
    surveys = []
    for number, source in enumerate(scenes or SCENES):
        progress("scenes", number, len(scenes or SCENES))
        scene = _sized(open_scene(source))
        surveys += [_survey(scene, kinds, folder, rivals, progress) for kinds in kinds_of(scene)]
    against = _measured(folder, "papers", lambda: papers.compare(progress=progress))
    if not (folder / "stability.json").exists():
        stability.chart((), stability.SIDE, folder, progress)
    regimes = json.loads((folder / "stability.json").read_text())
    sheets = {group: (folder / stability.sheet_name(group)).read_bytes() for group in GROUPS}
    charts = [as_svg(draw(found)) for found in surveys]
    for found, chart in zip(surveys, charts, strict=True):
        (folder / f"{_name(found['scene'], found['kinds'])}.svg").write_bytes(chart)
    path = folder / "report.html"
    path.write_text(page(surveys, charts, against, regimes, sheets))
    return [path, *sorted(folder.glob("*.json")), *sorted(folder.glob("*.svg"))]


def _survey(
    scene: Scene, kinds: Sequence[str], folder: Path, rivals: bool, progress: Progress
) -> dict[str, Any]:
    def measured() -> dict[str, Any]:
        for budget in BUDGETS:
            planned = plan(scene, kinds, budget, progress=progress)
            if planned.holds:
                break
        return survey(scene, planned, rivals=rivals, progress=progress)

    return _measured(folder, _name(scene.name, kinds), measured)


def _name(scene: str, kinds: Sequence[str]) -> str:
    return f"{scene}-{'-'.join(kinds)}"


def _measured(folder: Path, name: str, measure: Callable[[], dict[str, Any]]) -> dict[str, Any]:
    """What the folder has of that name, else what is measured, which it has from then on."""
    path = folder / f"{name}.json"
    if not path.exists():
        write_json(measure(), folder, name)
    found: dict[str, Any] = json.loads(path.read_text())
    return found


def _sized(scene: Scene) -> Scene:
    camera = scene.camera
    part = min(1.0, SIDE / max(camera.width, camera.height))
    size = {"width": round(part * camera.width), "height": round(part * camera.height)}
    return scene.with_camera(edited_camera(camera, size))
