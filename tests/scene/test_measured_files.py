"""Measured materials lie beside the scene, and what is wrong with one names its field and file."""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from brdf.acquisition.acquired import goniometer_file

from engine.brdf.acquisition.csv_table import COLUMNS
from engine.brdf.acquisition.merl import SHAPE
from engine.brdf.measured import Measured
from engine.errors import EditError, SceneError
from engine.scene.edits import Edits, apply
from engine.scene.open import open_scene
from engine.scene.scene import Scene

HEADER = ",".join(COLUMNS) + "\n"
MERL = np.array(SHAPE, "<i4").tobytes()
Described = Callable[..., Scene]

# Name of a file, what is in it, words that are said of it.
DAMAGED = [
    ("a.csv", b"", "'theta_i_degrees' is missing"),
    ("a.csv", HEADER.encode(), "no rows"),
    (
        "a.csv",
        HEADER.encode() + b"30,0,45,180,0.1,0.1,0.1\n30,0,45\n",
        "line 3: the row has 3 cells",
    ),
    ("a.csv", HEADER.encode() + b"95,0,45,180,0.1,0.1,0.1\n", "above the surface"),
    ("a.csv", bytes(range(256)), "a.csv"),
    ("a.brdf", b"# num wls\n3\n", "a.brdf"),
    ("a.brdf", bytes(range(256)), "a.brdf"),
    ("a.binary", b"short", "fewer than three numbers"),
    ("a.binary", np.array((9, 9, 18), "<i4").tobytes(), "this with 9 x 9 x 18"),
    ("a.binary", MERL + bytes(800), "cut short"),
    ("a.png", b"no measurement", "no file of a measured material"),
]


def matt(path: Path, value: float) -> Path:
    """A table of two samples of an even BRDF."""
    row = f",{value},{value},{value}\n"
    path.write_text(HEADER + "30,0,45,180" + row + "60,0,5,90" + row)
    return path


@pytest.mark.parametrize(("name", "content", "word"), DAMAGED)
def test_a_damaged_file_names_its_field_and_itself(
    described: Described, tmp_path: Path, name: str, content: bytes, word: str
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(SceneError) as caught:
        described(materials={"m": {"type": "measured", "file": name}})
    assert caught.value.field == "materials.m.file"
    assert caught.value.file == name
    assert word in str(caught.value)


@pytest.mark.parametrize("name", ["x" * 300, "a\0b", "..", "folder/none.csv"], ids=len)
def test_names_that_no_file_can_have(described: Described, name: str) -> None:
    with pytest.raises(SceneError, match="there is no such file, and built-in") as caught:
        described(materials={"m": {"type": "measured", "file": name}})
    assert (caught.value.field, caught.value.file) == ("materials.m.file", name)


def test_a_file_that_cannot_be_read(
    described: Described, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(path: Path) -> None:
        raise PermissionError(13, "Permission denied", str(path))

    matt(tmp_path / "a.csv", 0.3)
    monkeypatch.setattr("engine.brdf.acquisition.read", refuse)
    with pytest.raises(SceneError, match=r"cannot be read: Permission denied") as caught:
        described(materials={"m": {"type": "measured", "file": "a.csv"}})
    assert caught.value.field == "materials.m.file"


def test_a_damaged_file_in_an_edit(described: Described, tmp_path: Path) -> None:
    scene = described(materials={"m": {"type": "diffuse"}})
    (tmp_path / "a.csv").write_text(HEADER + "30,0,45,180,0.1,red,0.1\n")
    with pytest.raises(EditError) as caught:
        apply(scene, Edits(materials={"m": {"type": "measured", "file": "a.csv"}}))
    assert (caught.value.field, caught.value.file) == ("materials.m.file", "a.csv")
    for word in ("line 2", "red"):
        assert word in caught.value.message


@pytest.mark.parametrize("suffix", [".csv", ".brdf"])
def test_files_lie_beside_the_scene(described: Described, tmp_path: Path, suffix: str) -> None:
    """Wherever the process runs; an edit finds them there too."""
    path = tmp_path / f"paint{suffix}"
    if suffix == ".csv":
        matt(path, 0.1)
    else:
        goniometer_file(path, [(0.1 * k, 0.0, 0.5, 0.3 * k, 0.1, 0.1, 0.1) for k in range(10)])
    fields = {"type": "measured", "file": path.name}
    scene = described(materials={"m": fields, "n": {"type": "diffuse"}})
    assert isinstance(scene.materials[0], Measured)
    assert scene.materials[0].measurement().name == "paint"
    edited = apply(scene, Edits(materials={"n": fields}))
    assert edited.materials[1] == scene.materials[0]
    np.testing.assert_array_equal(edited.material_table.row[1], scene.material_table.row[0])


def test_a_file_that_has_changed_is_read_anew(described: Described, tmp_path: Path) -> None:
    path = matt(tmp_path / "a.csv", 0.1)
    fields = {"type": "measured", "file": path.name}
    before = described(materials={"m": fields})
    again = open_scene(tmp_path / "scene.json")
    assert again.materials[0].measurement() is before.materials[0].measurement()  # type: ignore[attr-defined]
    matt(path, 0.2)
    os.utime(path, ns=(1, 1))
    after = open_scene(tmp_path / "scene.json")
    assert after.materials != before.materials
    assert (after.material_table.row != before.material_table.row).any()
    assert after.transport_digest != before.transport_digest


def test_what_is_measured_stays_out_of_the_description(described: Described) -> None:
    """Only its file is written down, whatever has been read."""
    scene = described(materials={"m": {"type": "measured", "file": "brushed"}})
    assert set(scene.materials[0].model_dump()) == {"type", "emission", "specular", "file"}
