"""What was measured as JSON, with settings, machine, date and commit; tables in Markdown."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Sequence
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from engine.measure.machine import Machine
from engine.measure.points import COSTS, MAIN_ERROR, Point, Sweep, pareto_front
from engine.scene.edits import Edits


def provenance() -> dict[str, Any]:
    """Version, commit (None outside a checkout) and date of what was measured."""
    try:
        release = version("relight")
    except PackageNotFoundError:
        release = None
    now = datetime.now(UTC).isoformat(timespec="seconds")
    return {"relight": release, "commit": _commit(), "date": now}


def _commit() -> str | None:
    """Short hash of the checkout, with `+` where files differ from it."""
    git = ["git", "-C", str(Path(__file__).parent)]
    try:
        commit = subprocess.run(
            [*git, "rev-parse", "--short=10", "HEAD"], capture_output=True, text=True, check=True
        ).stdout.strip()
        changed = subprocess.run(
            [*git, "status", "--porcelain", "--untracked-files=no"],
            capture_output=True,
            text=True,
            check=True,
        ).stdout
    except (OSError, subprocess.CalledProcessError):
        return None
    return commit + ("+" if changed else "")


def sweep_document(sweep: Sweep, machine: Machine) -> dict[str, Any]:
    """A sweep as JSON; times in seconds, numbers that are not finite as null."""
    trial = sweep.trial
    camera = trial.scene.camera
    fronts = {cost: pareto_front(sweep.points, cost) for cost in COSTS}
    document = {
        **provenance(),
        "machine": machine.as_dict(),
        "scene": trial.scene.name,
        "width": camera.width,
        "height": camera.height,
        "triangles": len(trial.scene.geometry.triangles),
        "seed": sweep.seed,
        "main_error": MAIN_ERROR,
        "edge_share": float(np.mean([1.0 - kept.mean() for kept in trial.kept])),
        "edits": [_edit(edit) for edit in trial.edits],
        "drag": {"edits": [_edit(edit) for edit in trial.path], "own_change": trial.own_change},
        "references": [
            {"error": t.error, "floor": floor, "seconds": t.seconds, "samples": t.samples}
            for t, floor in zip(trial.truths, trial.floors, strict=True)
        ],
        "points": [
            {**point_document(point), "fronts": [cost for cost in COSTS if k in fronts[cost]]}
            for k, point in enumerate(sweep.points)
        ],
        "others": [point_document(point) for point in sweep.others],
    }
    return finite(document)


def _edit(edit: Edits) -> dict[str, Any]:
    return edit.model_dump(mode="json", exclude_none=True)


def point_document(point: Point) -> dict[str, Any]:
    """A measured setting as JSON."""
    return {
        "method": point.method,
        "knob": point.knob,
        "settings": point.settings,
        "error": point.error,
        "errors": point.errors,
        "frame_seconds": {
            "median": point.frame.median,
            "p95": point.frame.p95,
            "parts": point.parts,
        },
        "precompute_seconds": point.precompute,
        "bytes": point.bytes,
        "warnings": point.warnings,
    }


def finite(value: Any) -> Any:
    """The document with null for infinity and NaN, which JSON has not."""
    if isinstance(value, dict):
        return {key: finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [finite(item) for item in value]
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value


def write_json(document: dict[str, Any], folder: Path, name: str) -> Path:
    """Write a document into a folder, which is made where it is not there; returns its path."""
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{name}.json"
    path.write_text(json.dumps(document, indent=1, ensure_ascii=False) + "\n")
    return path


def table(head: Sequence[str], rows: Sequence[Sequence[str]], names: int = 1) -> list[str]:
    """Lines of a Markdown table, whose first `names` columns hold words and the others numbers."""
    rule = ["---"] * names + ["---:"] * (len(head) - names)
    return [f"| {' | '.join(row)} |" for row in (head, rule, *rows)]
