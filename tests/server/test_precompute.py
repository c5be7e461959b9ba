"""Precompute in its own process: fills the store, relays errors, ends when it is told to."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from engine.errors import Cancelled, InputError, NotFound, SceneError
from engine.methods import METHODS, prepare
from engine.scene.camera import Camera
from engine.scene.open import open_scene
from server.precompute import Task, run_in_process, settings_of

ROOT = Path(__file__).resolve().parents[2]


def task(source: Path, **settings: int) -> Task:
    anywhere = Camera(position=(0, 0, 1), target=(0, 0, 0))
    return Task(
        scene="tiny-box",
        source=str(source),
        camera=open_scene(source).camera if source.exists() else anywhere,
        method="direct_to_indirect",
        settings=settings,
    )


def children() -> list[str]:
    """Command lines of precompute processes that are alive."""
    listed = subprocess.run(
        ["ps", "-ww", "-o", "stat=,args=", "--ppid", str(os.getpid())],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return [
        line for line in listed.stdout.splitlines()
        if "server.precompute" in line and not line.startswith("Z")
    ]  # fmt: skip


def test_what_it_made_lies_in_the_store(
    tiny_scene: Path, quick: dict[str, int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path))
    phases: list[str] = []
    run_in_process(task(tiny_scene, **quick), lambda phase, done, total: phases.append(phase))
    assert {"start", "open scene", "bounce", "final"} <= set(phases)
    loaded: list[str] = []
    scene = open_scene(tiny_scene)
    product = prepare(
        scene,
        "direct_to_indirect",
        settings_of("direct_to_indirect", quick),
        lambda phase, done, total: loaded.append(phase),
    )
    assert product.method == "direct_to_indirect"
    assert set(loaded) == {"view samples"}, "it was computed again, not loaded"
    assert children() == []


def test_cancelled_within_a_second(
    tiny_scene: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path))
    stopped = 0.0

    def progress(phase: str, done: float, total: float) -> None:
        nonlocal stopped
        if phase == "start" and children():
            stopped = time.monotonic()
            raise Cancelled("enough")

    with pytest.raises(Cancelled, match="enough"):
        run_in_process(task(tiny_scene), progress)
    assert time.monotonic() - stopped < 1.0
    assert children() == []


def test_its_errors_come_home(tmp_path: Path) -> None:
    broken = tmp_path / "broken.json"
    broken.write_text('{"objects": 3}')
    wanted = task(tmp_path / "none.json")
    with pytest.raises(NotFound, match=r"none\.json"):
        run_in_process(wanted, lambda *_: None)
    with pytest.raises(SceneError) as error:
        run_in_process(wanted.model_copy(update={"source": str(broken)}), lambda *_: None)
    assert error.value.file == "broken.json"
    assert error.value.field


def test_it_does_not_outlive_its_parent(tiny_scene: Path, tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-m", "server.precompute"],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        cwd=ROOT,
        env={**os.environ, "RELIGHT_STORE": str(tmp_path), "PYTHONPATH": str(ROOT)},
        text=True,
        start_new_session=True,
    )
    assert process.stdin is not None
    assert process.stdout is not None
    process.stdin.write(task(tiny_scene).model_dump_json() + "\n")
    process.stdin.flush()
    assert "open scene" in process.stdout.readline()
    process.stdin.close()
    assert process.wait(timeout=5) != 0
    process.stdout.close()


def test_settings_are_checked() -> None:
    assert settings_of("direct_to_indirect", {}) == METHODS["direct_to_indirect"].settings()
    with pytest.raises(InputError, match="coefficients") as error:
        settings_of("direct_to_indirect", {"coefficient": 3})
    assert error.value.field == "settings.coefficient"
