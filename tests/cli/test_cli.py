"""The command line as a person types it: what it prints, writes and returns."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from engine.cli import main
from engine.images import read_image
from engine.scene.open import scenes

SMALL = ["--set", "gather_samples=1024", "--set", "coefficients=20"]


@pytest.fixture(scope="module")
def store(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("store")


@dataclass
class Run:
    """What a run of `relight` left behind."""

    returncode: int
    stdout: str
    stderr: str


class Relight:
    """Runs `relight` in this process, in a folder and with a store of its own."""

    def __init__(
        self,
        store: Path,
        folder: Path,
        monkeypatch: pytest.MonkeyPatch,
        capsys: pytest.CaptureFixture[str],
    ) -> None:
        self.store, self.folder, self._monkeypatch, self._capsys = (
            store,
            folder,
            monkeypatch,
            capsys,
        )
        monkeypatch.chdir(folder)
        monkeypatch.setenv("RELIGHT_STORE", str(store))

    def __call__(self, *arguments: str) -> Run:
        self._monkeypatch.setattr(sys, "argv", ["relight", *arguments])
        with pytest.raises(SystemExit) as end:
            main()
        printed = self._capsys.readouterr()
        return Run(int(end.value.code or 0), printed.out, printed.err)

    def fails(self, status: int, *arguments: str) -> str:
        """The one line that it says."""
        run = self(*arguments)
        assert run.returncode == status, run.stderr
        assert run.stdout == ""
        lines = run.stderr.strip().splitlines()
        assert len(lines) == 1, run.stderr
        assert lines[0].startswith("relight: ")
        return lines[0]


@pytest.fixture
def relight(
    store: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> Relight:
    return Relight(store, tmp_path, monkeypatch, capsys)


def test_as_a_process(tmp_path: Path) -> None:
    """No traceback and the right status outside of pytest too."""
    run = subprocess.run(
        [sys.executable, "-m", "engine.cli", "render", "no-such-scene", "--out", "x.png"],
        cwd=tmp_path,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
    )
    assert run.returncode == 2
    assert run.stdout == ""
    assert re.fullmatch(r"relight: .*no-such-scene.*\n", run.stderr)


def test_scenes_lists_what_is_built_in(relight: Relight) -> None:
    run = relight("scenes")
    assert run.returncode == 0
    for name, summary in scenes().items():
        assert name in run.stdout
        assert summary in run.stdout


def test_help_names_every_verb(relight: Relight) -> None:
    run = relight("--help")
    assert run.returncode == 0
    for verb in ("scenes", "precompute", "render", "chart", "bench", "serve"):
        assert verb in run.stdout


def test_precompute_then_render_under_edits(relight: Relight) -> None:
    run = relight("precompute", "cornell-box", "--size", "48x40", *SMALL)
    assert run.returncode == 0, run.stderr
    assert "coefficients = 20" in run.stdout
    files = {p: p.stat().st_mtime_ns for p in relight.store.rglob("*") if p.is_file()}
    assert files

    edits = {"lights": [{"id": "key", "position": [0.2, 0.4, 0.1]}]}
    (relight.folder / "edits.json").write_text(json.dumps(edits))
    pictures = []
    for name, more in (("plain.exr", []), ("moved.exr", ["--edits", "edits.json"])):
        run = relight("render", "cornell-box", "--size", "48x40", *SMALL, "--out", name, *more)
        assert run.returncode == 0, run.stderr
        pictures.append(read_image(relight.folder / name))
    plain, moved = pictures
    assert plain.shape == (40, 48, 3)
    assert np.isfinite(plain).all()
    assert plain.mean() > 0
    assert np.abs(plain - moved).max() > 0.01 * plain.max()
    # What precompute had stored was used as it was.
    assert {p: p.stat().st_mtime_ns for p in files} == files


def test_reference_render(relight: Relight) -> None:
    run = relight(
        "render",
        "cornell-box",
        "--method",
        "reference",
        "--size",
        "32x32",
        "--samples",
        "16",
        "--out",
        "truth.png",
        "--exposure",
        "1",
    )
    assert run.returncode == 0, run.stderr
    assert "16 samples per pixel" in run.stdout
    assert read_image(relight.folder / "truth.png").shape == (32, 32, 3)


def test_another_camera_is_another_precompute(relight: Relight) -> None:
    (relight.folder / "edits.json").write_text('{"camera": {"fov_y_degrees": 20}}')
    for name, more in (("a.exr", []), ("b.exr", ["--edits", "edits.json"])):
        run = relight("render", "cornell-box", "--size", "24x24", *SMALL, "--out", name, *more)
        assert run.returncode == 0, run.stderr
    a, b = (read_image(relight.folder / name) for name in ("a.exr", "b.exr"))
    assert np.abs(a - b).max() > 0.01 * a.max()


@pytest.mark.gl
def test_both_backends_write_the_same_picture(relight: Relight) -> None:
    pictures = []
    for name in ("cpu", "gl"):
        where = ["--backend", name, "--out", f"{name}.exr"]
        run = relight("render", "cornell-box", "--size", "24x24", *SMALL, *where)
        assert run.returncode == 0, run.stderr
        assert "The CPU draws" not in run.stderr
        pictures.append(read_image(relight.folder / f"{name}.exr"))
    assert np.linalg.norm(pictures[0] - pictures[1]) < 1e-3 * np.linalg.norm(pictures[0])


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["render", "no-such-scene", "--out", "x.exr"], "no-such-scene"),
        (["render", "cornell-box", "--out", "x.tiff"], "x.tiff"),
        (["render", "cornell-box", "--size", "16", "--out", "x.exr"], "size: '16'"),
        (["render", "cornell-box", "--size", "0x16", "--out", "x.exr"], "camera.width"),
        (["render", "cornell-box", "--method", "magic", "--out", "x.exr"], "'magic'"),
        (["precompute", "cornell-box", "--set", "coefficient=3"], "coefficient: no such setting"),
        (["precompute", "cornell-box", "--set", "coefficients=lots"], "coefficients: 'lots'"),
        (["precompute", "cornell-box", "--set", "coefficients"], "key=value"),
        (["render", "cornell-box", "--edits", "none.json", "--out", "x.exr"], "none.json"),
        (["render", "cornell-box", "--edits", "broken.json", "--out", "x.exr"], "broken.json"),
        (["render", "cornell-box", "--edits", "unknown.json", "--out", "x.exr"], "sun"),
        (["render", "cornell-box", "--edits", "matt.json", "--out", "x.exr"], "brdf_editing"),
        (["render", "cornell-box", "--edits", "ghost.json", "--out", "x.exr"], "lights.0"),
        (["render", "cornell-box", "--out", "nowhere/x.exr"], "no such folder"),
        (["render", "cornell-box", "--samples", "9", "--out", "x.exr"], "--method reference"),
        (["precompute", "cornell-box", "--error", "0.1", "--set", "bounces=1"], "leave --set out"),
        (["precompute", "cornell-box", "--edits", "lights"], "--edits is for --error"),
        (["render", "cornell-box", "--backend", "vulkan", "--out", "x.exr"], "backend: 'vulkan'"),
        (
            ["render", "cornell-box", "--method", "reference", "--backend", "gl", "--out", "x.exr"],
            "no backends",
        ),
        (["chart", "cornell-box", "--sweep", "bounce=1,2", "--out", "c"], "bounce"),
        (["chart", "--out", "c"], "SCENE: this chart is of a scene"),
        (["chart", "--growth", "--tables", "--out", "c"], "--growth and --tables"),
        (["chart", "--figure", "7", "--out", "c"], "figure: 7 is not made; there are 6, 8, 10, 11"),
        (["chart", "--tables", "--method", "magic", "--out", "c"], "of glossy_prt's paper"),
        (["chart", "none.obj", "--tables", "--out", "c"], "none.obj: cannot be read"),
        (["chart", "--accuracy", "--environments", ".", "--out", "c"], "there is no map"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(
    relight: Relight, arguments: list[str], message: str
) -> None:
    (relight.folder / "broken.json").write_text("{")
    (relight.folder / "unknown.json").write_text('{"sun": {}}')
    (relight.folder / "matt.json").write_text('{"materials": {"white": {"diffuse": [1, 0, 0]}}}')
    (relight.folder / "ghost.json").write_text(
        '{"lights": [{"id": "ghost", "position": [0, 0, 0]}]}'
    )
    assert message in relight.fails(2, *arguments)


def test_wrong_usage_has_status_2(relight: Relight) -> None:
    run = relight("render", "cornell-box")
    assert run.returncode == 2
    assert "--out" in run.stderr
    assert "Traceback" not in run.stderr


def test_a_figure_of_the_paper(relight: Relight) -> None:
    """Of a mesh file; the folder gets a picture and its numbers."""
    (relight.folder / "roof.obj").write_text(
        "v 0 0 0\nv 1 1 0\nv 1 1 2\nv 0 0 2\nv 2 0 0\nv 2 0 2\nf 1 4 3 2\nf 2 3 6 5\nf 1 5 6 4\n"
    )
    small = [f"{name}=16" for name in ("light_texels", "visibility_texels", "brdf_texels")]
    sets = [word for setting in small for word in ("--set", setting)]
    run = relight("chart", "roof.obj", "--figure", "8", "--size", "24x20", *sets, "--out", "c")
    assert run.returncode == 0, run.stderr
    assert [Path(line).name for line in run.stdout.split()] == ["figure-8.png", "figure-8.json"]
    document = json.loads((relight.folder / "c" / "figure-8.json").read_text())
    assert (document["object"], document["width"], document["height"]) == ("roof", 24, 20)
    assert document["settings"]["brdf_texels"] == 16
    assert [p["terms"] for p in document["pictures"]] == [1, 2, 4, 8, 16]
    assert document["reference_error"] == 0.02
    assert read_image(relight.folder / "c" / "figure-8.png").shape[1] > 500


def test_a_figure_of_measured_materials(relight: Relight) -> None:
    """Materials by name, before the paper's figures of that method."""
    of_codes = ["chart", "--method", "wavelet_brdf", "--out", "c"]
    run = relight(*of_codes, "brushed", "--figure", "9", "--size", "48x40")
    assert run.returncode == 0, run.stderr
    document = json.loads((relight.folder / "c" / "figure-9.json").read_text())
    assert [p["material"] for p in document["pictures"]] == ["brushed"]
    assert document["pictures"][0]["lab"] < 2
    assert "there are 3, 8, 9, 10" in relight.fails(2, *of_codes, "--figure", "4")
    assert "none.brdf" in relight.fails(2, *of_codes, "none.brdf", "--figure", "9")


def test_chart_of_a_small_sweep(relight: Relight) -> None:
    run = relight(
        "chart",
        "cornell-box",
        "--method",
        "direct_to_indirect",
        "--size",
        "24x24",
        "--set",
        "gather_samples=1024",
        "--sweep",
        "coefficients=4,64",
        "--edits",
        "2",
        "--reference-error",
        "0.2",
        "--out",
        "chart",
    )
    assert run.returncode == 0, run.stderr
    folder = relight.folder / "chart"
    assert {path.name for path in folder.iterdir()} == {"chart.svg", "chart.png", "chart.json"}
    document = json.loads((folder / "chart.json").read_text())
    points = document["points"]
    assert [p["settings"]["coefficients"] for p in points[1:]] == [4, 64]
    assert all(p["settings"]["gather_samples"] == 1024 for p in points)
    for cost in ("frame_seconds", "bytes", "precompute_seconds"):
        assert any(cost in p["fronts"] for p in points)
    traced = document["others"]
    assert {p["method"] for p in traced} == {"path tracer"}
    assert [p["settings"]["samples"] for p in traced[:3]] == [1, 4, 16]
    assert traced[0]["error"]["relative_l2"] > traced[2]["error"]["relative_l2"]
    assert 0 <= points[2]["error"]["flicker"] < traced[0]["error"]["flicker"]
    assert 0 < document["drag"]["own_change"] < 1
    for p in points:
        assert p["bytes"] > 0
        assert p["precompute_seconds"] > 0
        assert 0 < p["error"]["relative_l2"] < 2
        assert len(p["errors"]) == len(document["edits"]) == len(document["references"]) == 2
    assert points[1]["bytes"] < points[2]["bytes"]
    assert document["machine"]["memory_read_gb_s"] > 0


def test_a_plan_in_words_and_as_json(relight: Relight) -> None:
    asked = ["plan", "cornell-box", "--edits", "lights", "--error", "0.75", "--size", "16x16"]
    run = relight(*asked, "--method", "wavelet_brdf")
    assert run.returncode == 0, run.stderr
    first, *others = run.stdout.splitlines()
    assert first.startswith("wavelet_brdf: ")
    assert "which holds 75 %" in first
    assert any("cells = 16: the least is enough" in line for line in others)
    document = json.loads(relight(*asked, "--method", "wavelet_brdf", "--json").stdout)
    assert document["method"] == "wavelet_brdf"
    assert document["holds"]
    assert document["settings"]["cells"] == 16
    assert "glossy_prt" in relight.fails(2, "plan", "cornell-box", "--edits", "environment,lights",
                                         "--method", "glossy_prt")  # fmt: skip


def test_an_error_in_place_of_a_method_and_its_settings(relight: Relight) -> None:
    """A newcomer asks for an error; what is planned is what is made and drawn."""
    small = ["cornell-box", "--error", "0.75", "--size", "16x16"]
    run = relight("precompute", *small, "--edits", "lights")
    assert run.returncode == 0, run.stderr
    first, *others = run.stdout.splitlines()
    assert first.startswith("wavelet_brdf: "), "with so much room nothing indirect is needed"
    assert any(line.startswith("wavelet_brdf of cornell-box") for line in others)
    (relight.folder / "edits.json").write_text('{"lights": [{"id": "key", "enabled": false}]}')
    drawn = relight("render", *small, "--edits", "edits.json", "--out", "dark.png")
    assert drawn.returncode == 0, drawn.stderr
    assert drawn.stdout.startswith("wavelet_brdf: ")
    assert (relight.folder / "dark.png").exists()


def test_growth_of_one_setting(relight: Relight) -> None:
    small = ["--size", "24x24", "--set", "gather_samples=1024", "--reference-error", "0.3"]
    sweep = ["--sweep", "coefficients=4,32", "--edits", "1"]
    run = relight("chart", "cornell-box", "--growth", *small, *sweep, "--out", "growth")
    assert run.returncode == 0, run.stderr
    folder = relight.folder / "growth"
    assert {path.name for path in folder.iterdir()} == {"growth.svg", "growth.png", "growth.json"}
    points = json.loads((folder / "growth.json").read_text())["points"]
    assert [(p["knob"], p["size"]) for p in points] == [("coefficients", 4), ("coefficients", 32)]
    assert points[0]["bytes"] < points[1]["bytes"]


def test_rivals_that_are_not_installed_are_named(
    relight: Relight, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Before there is a precompute to wait for."""
    for name in ("rivals", "mitsuba_renderer"):
        monkeypatch.delitem(sys.modules, f"engine.measure.{name}", raising=False)
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    line = relight.fails(1, "bench", "cornell-box", "--size", "16x16", "--rivals")
    assert "mitsuba" in line
    assert "relight[peers]" in line
    line = relight.fails(1, "chart", "cornell-box", "--size", "16x16", "--rivals", "--out", "chart")
    assert "relight[peers]" in line
