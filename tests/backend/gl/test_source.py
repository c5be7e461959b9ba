"""Shaders are put together once from each part, and their errors name file and line."""

from __future__ import annotations

import pytest

from engine.backend.gl.context import Device
from engine.backend.gl.source import load
from engine.backend.gl.tables import MODULES, brdf_table, chosen_light, file_name
from engine.errors import BackendError
from engine.light.table import LIGHTS
from engine.resources import resource

FILES = {
    "main.glsl": '#include "a.glsl"\n#include "b.glsl"\nvoid main() {}\n',
    "a.glsl": 'float a;\n#include "c.glsl"\nfloat after_c;\n',
    "b.glsl": '  #include "c.glsl"\nfloat b;\n',
    "c.glsl": "float c;\n",
}


def test_every_file_once_however_deep() -> None:
    assert load("main.glsl", {"ROWS": 64}, FILES).text.splitlines() == [
        "#version 430", "#define ROWS 64", "float a;", "float c;", "float after_c;", "float b;",
        "void main() {}",
    ]  # fmt: skip


def test_every_line_knows_its_place() -> None:
    source = load("main.glsl", {"ROWS": 64}, FILES)
    lines = source.text.splitlines()
    assert len(lines) == len(source.places)
    for line, place in list(zip(lines, source.places, strict=True))[2:]:
        file, number = place.split(":")
        assert FILES[file].splitlines()[int(number) - 1] == line


@pytest.mark.parametrize(
    ("log", "said"),
    [
        ("0:5(7): error: x", "a.glsl:3: error: x"),
        ("0(5) : error C1: x", "a.glsl:3 : error C1: x"),
        ("ERROR: 0:5: x", "ERROR: a.glsl:3: x"),
        ("two\n0:4(7): error: x", "two\nc.glsl:1: error: x"),
        ("0:99(7): error: x", "0:99(7): error: x"),
    ],
)
def test_logs_of_all_makers(log: str, said: str) -> None:
    assert load("main.glsl", {"ROWS": 64}, FILES).explain(log) == said


def test_a_missing_file_is_named_with_who_wants_it() -> None:
    with pytest.raises(BackendError, match=r"gone\.glsl, which main\.glsl:2 includes"):
        load("main.glsl", None, {"main.glsl": '\n#include "gone.glsl"\n'})


@pytest.mark.gl
def test_an_error_of_the_compiler_names_file_and_line(gpu: Device) -> None:
    broken = {**FILES, "c.glsl": "float c;\nfloat d = nothing;\n"}
    with pytest.raises(BackendError, match=r"c\.glsl:2"):
        gpu.program("main.glsl", made=broken)


def test_every_model_and_light_has_a_shader_of_its_name() -> None:
    for folder, modules in (("brdf", MODULES), ("light", LIGHTS.values())):
        for module in modules:
            name = file_name(module)
            text = (resource("shaders") / folder / f"{name}.glsl").read_text()
            assert f" {'evaluate' if folder == 'brdf' else 'illuminate'}_{name}(" in text
    assert all(f"model == {k}" in brdf_table() for k in range(len(MODULES)))
    assert "#define illuminate illuminate_spot" in chosen_light(1).splitlines()
