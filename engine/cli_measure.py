"""`relight chart`, `bench` and `plan`: what is measured, and what follows from it."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from engine.arguments import (
    DEFAULT_METHOD,
    known_method,
    needs_extra,
    settings_of,
    sized_scene,
    words,
)
from engine.errors import InputError
from engine.measure.settings import parse_assignments
from engine.options import (
    KindsOption,
    MethodOption,
    MethodsOption,
    SceneArgument,
    SetOption,
    SizeOption,
)
from engine.scene.scene import Scene
from engine.terminal import out, progress_bars

if TYPE_CHECKING:
    from engine.measure.planner import Plan


def chart(
    scenes: Annotated[
        list[str] | None,
        typer.Argument(metavar="[SCENE]...", help="a built-in scene, a scene, mesh or BRDF file"),
    ] = None,
    to: Annotated[
        Path | None, typer.Option("--out", help="folder for the chart and its numbers")
    ] = None,
    method: MethodsOption = None,
    of: Annotated[
        str | None,
        typer.Option(
            help="edits to judge on: lights, materials, environment or camera; without --method "
            "all that take such edits are charted"
        ),
    ] = None,
    rivals: Annotated[
        bool, typer.Option("--rivals", help="Mitsuba 3 beside, alone and denoised; takes minutes")
    ] = False,
    sweep: Annotated[
        list[str] | None,
        typer.Option("--sweep", metavar="KEY=A,B,...", help="values in place of the usual sweep"),
    ] = None,
    edits: Annotated[int, typer.Option(min=1, help="how many unseen edits to judge on")] = 4,
    seed: Annotated[int, typer.Option(min=0, help="draws the edits")] = 1,
    growth: Annotated[
        bool, typer.Option("--growth", help="instead: how cost grows with scene and settings")
    ] = False,
    factorisation: Annotated[
        bool,
        typer.Option(
            "--factorisation",
            help="instead: how well K terms fit the scene's BRDFs, or the paper's without one",
        ),
    ] = False,
    accuracy: Annotated[
        bool,
        typer.Option(
            "--accuracy", help="instead: glossy_prt by material, environment, bounces and setting"
        ),
    ] = False,
    environments: Annotated[
        Path | None, typer.Option(help="folder of the maps that --accuracy takes")
    ] = None,
    tables: Annotated[
        bool, typer.Option("--tables", help="instead: tables of --method's paper, or glossy_prt's")
    ] = False,
    report: Annotated[
        Path | None,
        typer.Option(
            help="instead, into this folder: one page with the charts and plans of the SCENEs, or "
            "the built-in ones, and the papers' figures; takes hours, and can be resumed"
        ),
    ] = None,
    figure: Annotated[
        list[int] | None,
        typer.Option(help="instead: figures of the paper of glossy_prt, or of --method's"),
    ] = None,
    stability: Annotated[
        bool,
        typer.Option(
            "--stability", help="instead: where methods fail, by how much, and what is said of it"
        ),
    ] = False,
    floor: Annotated[
        int | None, typer.Option(min=1, max=2048, help="cuts of the floor below a mesh file")
    ] = None,
    reference_error: Annotated[
        float | None,
        typer.Option(min=1e-4, max=1, help="relative L2 error of references; 0.05, figures 0.02"),
    ] = None,
    set_: SetOption = None,
    size: SizeOption = None,
) -> None:
    """Chart a method's speed against its accuracy over its settings, or something else instead.

    --accuracy, --tables and --figure are of a mesh file's object, or a knot; those of wavelet_brdf
    take BRDF files too, figures of brdf_editing built-in scenes and the width of --size.
    --stability is of scenes of its own.
    """
    with needs_extra("chart"):
        from engine import charts
    others = {
        "growth": growth,
        "factorisation": factorisation,
        "accuracy": accuracy,
        "tables": tables,
        "figure": figure,
        "report": report,
        "stability": stability,
    }
    folder = report or to
    if folder is None:
        raise InputError("say which folder the chart goes into", field="out")
    asked = charts.Asked(
        scenes=scenes or [],
        methods=method or [],
        of=of,
        rivals=rivals,
        set=set_ or [],
        sweep=sweep,
        size=size,
        edits=edits,
        seed=seed,
        reference_error=reference_error,
        floor=floor,
        environments=environments,
        figures=figure or [],
    )
    with progress_bars() as progress:
        paths = charts.write([k for k in others if others[k]], asked, folder, progress)
    for path in paths:
        out.print(str(path))


def plan(
    scene: SceneArgument,
    edits: KindsOption = None,
    error: Annotated[float, typer.Option(help="relative L2 error that is allowed")] = 0.05,
    method: MethodsOption = None,
    size: SizeOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="print JSON in place of words")] = False,
) -> None:
    """Say what would be modelled for an error budget, and why: method, settings, time and bytes."""
    found = _planned(sized_scene(scene, size), method, error, words(edits or ""))
    if as_json:
        print(json.dumps(found.as_dict(), indent=1))
    else:
        _print(found)


def chosen(
    scene: Scene, method: str | None, set_: list[str] | None, error: float | None, kinds: list[str]
) -> tuple[str, Any]:
    """(method, settings): as they are asked for, or planned where there is an error to hold.

    kinds are what is to be edited; for none it is what the method, or the scene, is made for.
    """
    if error is None:
        name = method or DEFAULT_METHOD
        return name, settings_of(name, set_)
    if set_:
        raise InputError("--error chooses the settings: leave --set out", field="error")
    found = _planned(scene, [method] if method else None, error, kinds)
    _print(found)
    return found.method, found.settings


def _print(found: Plan) -> None:
    out.print(*found.lines(), sep="\n", highlight=False)


def _planned(scene: Scene, methods: list[str] | None, error: float, kinds: list[str]) -> Plan:
    with needs_extra("chart"):
        from engine.measure.held_out import kind_of_edits
        from engine.measure.planner import plan as make_plan
    names = [known_method(name) for name in methods] if methods else None
    if not kinds:
        kinds = [kind_of_edits(names)] if names else ["lights" if scene.lights else "environment"]
    with progress_bars() as progress:
        return make_plan(scene, kinds, error, names, progress=progress)


def bench(
    scenes: Annotated[
        list[str] | None, typer.Argument(metavar="[SCENE]...", help="in place of the usual two")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print JSON in place of a table")] = False,
    history: Annotated[
        Path | None, typer.Option(help="append the result to this file, one line of JSON")
    ] = None,
    method: MethodOption = DEFAULT_METHOD,
    rivals: Annotated[
        bool, typer.Option("--rivals", help="against Mitsuba 3, alone and denoised; takes minutes")
    ] = False,
    gl: Annotated[
        bool, typer.Option("--gl", help="the same frames by OpenGL too, and how far apart they are")
    ] = False,
    service: Annotated[
        bool,
        typer.Option("--service", help="instead: transport, many clients, some that stop, start"),
    ] = False,
    seconds: Annotated[
        float, typer.Option(min=1, help="that the many clients of --service drag at once")
    ] = 120.0,
    set_: SetOption = None,
    size: SizeOption = None,
) -> None:
    """Time precompute and frames, as ratios to this machine's bandwidth and to other renderers."""
    if service:
        _bench_service(scenes or ["cornell-box"], seconds, as_json)
        return
    with needs_extra("chart"):
        from engine.measure.bench import SCENES
        from engine.measure.bench import bench as run_bench
        from engine.measure.bench_tables import bench_tables
    opened = [sized_scene(scene, size) for scene in scenes or SCENES]
    with progress_bars() as progress, needs_extra("peers"):
        document = run_bench(
            opened,
            progress,
            parse_assignments(set_ or ()),
            method=known_method(method),
            against_rivals=rivals,
            with_gl=gl,
        )
    if history is not None:
        history.parent.mkdir(parents=True, exist_ok=True)
        with history.open("a") as file:
            file.write(json.dumps(document) + "\n")
    if as_json:
        print(json.dumps(document, indent=1))
    else:
        out.print(*bench_tables(document), sep="\n")


def _bench_service(scenes: list[str], seconds: float, as_json: bool) -> None:
    from server.bench import bench as run_bench
    from server.bench_table import lines

    if len(scenes) > 1:
        raise InputError("--service takes one scene")
    with progress_bars() as progress:
        document = run_bench(scenes[0], seconds, progress)
    if as_json:
        print(json.dumps(document, indent=1))
    else:
        out.print(*lines(document), sep="\n", highlight=False, markup=False)
