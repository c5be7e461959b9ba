"""`relight doctor`: what is wrong with a machine, and what would mend it."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

from engine import doctor
from engine.cli import app
from engine.doctor import Finding, examine
from engine.errors import BackendError
from engine.store import Store

Look = Callable[[str], Finding]


@pytest.fixture
def look(tmp_path: Path) -> Look:
    """look(what): the finding of that name, with a store of this test's own."""

    def found(what: str) -> Finding:
        (one,) = [each for each in examine(Store(tmp_path / "store")) if each.what == what]
        return one

    return found


def test_nothing_is_broken_here_and_nothing_is_left_behind(tmp_path: Path) -> None:
    findings = examine(Store(tmp_path))
    assert [each.what for each in findings] == [
        "relight", "threads", "Embree", "OpenGL", "kernels", "store",
    ]  # fmt: skip
    assert not [each for each in findings if each.state == "broken"]
    assert list(tmp_path.iterdir()) == []


def test_more_threads_than_cores_are_noted(look: Look, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RELIGHT_THREADS", "900")
    found = look("threads")
    assert found.state == "note"
    assert found.do.startswith("export RELIGHT_THREADS=")


def test_the_limit_of_a_container_counts(
    look: Look, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    quota = tmp_path / "cpu.max"
    quota.write_text("50000 100000\n")
    monkeypatch.setattr(doctor, "CPU_QUOTA", quota)
    monkeypatch.setenv("RELIGHT_THREADS", "2")
    found = look("threads")
    assert (found.state, found.do) == ("note", "export RELIGHT_THREADS=1")
    assert "2 threads for 0.5 cores" in found.says


class Blind:
    """A ray tracer that meets nothing."""

    def __init__(self, *of: object) -> None:
        pass

    def intersect(self, origins: np.ndarray, directions: np.ndarray) -> SimpleNamespace:
        return SimpleNamespace(triangle=np.full(len(origins), -1))


def test_a_tracer_that_misses_is_broken(look: Look, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(doctor, "RayTracer", Blind)
    assert look("Embree").state == "broken"


def test_without_opengl_the_cpu_draws(look: Look, monkeypatch: pytest.MonkeyPatch) -> None:
    def none() -> None:
        raise BackendError("no libEGL; on Debian and Ubuntu: apt-get install libegl1")

    monkeypatch.setenv("RELIGHT_BACKEND", "auto")
    monkeypatch.setattr(doctor, "device", none)
    found = look("OpenGL")
    assert found.state == "note"
    assert "the CPU draws" in found.says
    assert "apt-get install" in found.says


def test_kernels_that_cannot_be_kept_are_noted(
    look: Look, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setattr(doctor.numba.config, "CACHE_DIR", str(tmp_path / "file" / "kernels"))
    found = look("kernels")
    assert found.state == "note"
    assert "NUMBA_CACHE_DIR" in found.do


def test_a_disk_that_is_nearly_full_is_noted_and_a_full_one_broken(
    look: Look, monkeypatch: pytest.MonkeyPatch
) -> None:
    for free, state in ((1e9, "note"), (1e6, "broken")):
        monkeypatch.setattr(
            doctor.shutil, "disk_usage", lambda root, free=free: SimpleNamespace(free=free)
        )
        found = look("store")
        assert found.state == state
        assert found.do.startswith("rm -r ")


def test_a_store_that_cannot_be_written_ends_with_status_1(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("RELIGHT_STORE", str(tmp_path / "file" / "store"))
    said = CliRunner().invoke(app, ["doctor"])
    assert said.exit_code == 1
    assert "broken store" in said.output
    assert "do: export RELIGHT_STORE=" in said.output
    document = json.loads(CliRunner().invoke(app, ["doctor", "--json"]).output)
    assert document[-1]["state"] == "broken"
