"""`relight chart`: which chart goes by which word, and what goes into it.

It needs the packages of the extra `chart`, so the command line imports it late.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

from engine.arguments import (
    DEFAULT_METHOD,
    knobs,
    known_method,
    materials_of,
    needs_extra,
    picture_size,
    sized_scene,
)
from engine.brdf.measured import Measured
from engine.errors import InputError
from engine.measure import (
    accuracy,
    accuracy_chart,
    code_figures,
    code_stage,
    code_tables,
    contact_sheet,
    editing_figures,
    editing_session,
    factorisation_chart,
    figures,
    growth_chart,
    stability,
    tables,
)
from engine.measure.chart import write_chart
from engine.measure.document import sweep_document
from engine.measure.growth import growth
from engine.measure.held_out import methods_for
from engine.measure.machine import this_machine
from engine.measure.points import Sweep
from engine.measure.report import write_report
from engine.measure.settings import parse_assignments
from engine.measure.stage import Thing, knot, read_thing
from engine.measure.sweep import REFERENCE_ERROR, sweep
from engine.methods.base import Progress
from engine.scene.mesh_files import FORMATS

Makers = dict[int, Callable[[], contact_sheet.Sheet]]
"""What makes a figure, by its number."""

PAPERS_OWN = accuracy.METHOD  # the method whose paper has the tables and the figures


@dataclass(frozen=True)
class Asked:
    """The words of the command line; None or an empty list where nothing was said.

    scenes        names or files
    of            which edits to judge on
    rivals        whether Mitsuba is among the others
    set           KEY=VALUE, settings that hold throughout
    sweep         KEY=A,B,...
    size          WxH
    floor         cuts of the floor along both sides
    environments  folder of maps
    figures       numbers of the paper's
    """

    scenes: list[str]
    methods: list[str]
    of: str | None
    rivals: bool
    set: list[str]
    sweep: list[str] | None
    size: str | None
    edits: int
    seed: int
    reference_error: float | None
    floor: int | None
    environments: Path | None
    figures: list[int]

    @property
    def fixed(self) -> dict[str, Any]:
        """The assignments of `set` by key."""
        return parse_assignments(self.set)

    def pixels(self, usual: tuple[int, int]) -> tuple[int, int]:
        """Width and height."""
        return usual if self.size is None else picture_size(self.size)

    def error(self, usual: float = REFERENCE_ERROR) -> float:
        """Relative L2 error of references."""
        return usual if self.reference_error is None else self.reference_error

    def one_scene(self) -> str:
        """The only scene; InputError for none and for several."""
        if len(self.scenes) != 1:
            raise InputError("this chart is of a scene, and of one", field="SCENE")
        return self.scenes[0]

    def thing(self) -> Thing:
        """The object of the only mesh file, or a knot for none; InputError for several."""
        return read_thing(self.one_scene()) if self.scenes else knot()

    def require_papers_own(self) -> None:
        """InputError where another method was asked for."""
        if set(self.methods) - {PAPERS_OWN}:
            raise InputError(f"this chart is of {PAPERS_OWN}'s paper", field="method")


def write(kinds: Sequence[str], asked: Asked, folder: Path, progress: Progress) -> list[Path]:
    """Make the chart of the one kind that is asked for, see CHARTS, or that of speed against
    accuracy for none; returns the files that were written into the folder.
    """
    if len(kinds) > 1:
        raise InputError(f"--{' and --'.join(kinds)} are charts of their own: ask for one")
    return CHARTS[kinds[0]](asked, folder, progress) if kinds else _sweep(asked, folder, progress)


def _sweep(asked: Asked, folder: Path, progress: Progress) -> list[Path]:
    methods = asked.methods or (methods_for(asked.of) if asked.of else [DEFAULT_METHOD])
    with needs_extra("peers"):
        result = _swept(asked, [known_method(name) for name in methods], progress)
    return write_chart(sweep_document(result, this_machine()), folder)


def _swept(asked: Asked, methods: Sequence[str], progress: Progress) -> Sweep:
    return sweep(
        sized_scene(asked.one_scene(), asked.size),
        methods,
        of=asked.of,
        fixed=asked.fixed,
        knobs=knobs(asked.sweep),
        edits=asked.edits,
        seed=asked.seed,
        reference_error=asked.error(),
        rivals=asked.rivals,
        progress=progress,
    )


def _growth(asked: Asked, folder: Path, progress: Progress) -> list[Path]:
    if len(asked.methods) > 1:
        raise InputError("growth is charted of one method at a time", field="method")
    method = known_method((asked.methods or [DEFAULT_METHOD])[0])
    if method == PAPERS_OWN and Path(asked.one_scene()).suffix.lower().lstrip(".") in FORMATS:
        cuts = asked.floor or accuracy.CUTS
        scene = tables.brushed(asked.thing(), asked.pixels(tables.SIZE), cuts)
    else:
        scene = sized_scene(asked.one_scene(), asked.size)
    grown = growth(
        scene,
        method=method,
        fixed=asked.fixed,
        axes=knobs(asked.sweep),
        edits=asked.edits,
        seed=asked.seed,
        reference_error=asked.error(),
        progress=progress,
    )
    return growth_chart.write(scene, grown, this_machine(), folder)


def _factorisation(asked: Asked, folder: Path, progress: Progress) -> list[Path]:
    source = asked.one_scene() if asked.scenes else None
    return factorisation_chart.write(materials_of(source), folder, progress)


def _accuracy(asked: Asked, folder: Path, progress: Progress) -> list[Path]:
    asked.require_papers_own()
    document = accuracy.study(
        asked.thing(),
        accuracy.environments_in(asked.environments),
        asked.pixels(accuracy.SIZE),
        folder=asked.environments or Path(),
        cuts=asked.floor or accuracy.CUTS,
        fixed=asked.fixed,
        knobs=knobs(asked.sweep),
        reference_error=asked.error(),
        progress=progress,
    )
    return accuracy_chart.write(document, folder)


def _tables(asked: Asked, folder: Path, progress: Progress) -> list[Path]:
    if asked.methods == [code_stage.METHOD]:
        thing, materials = _objects_and_materials(asked)
        measured = {name: material.measurement() for name, material in materials.items()}
        size = asked.pixels(tables.SIZE)
        made = code_tables.make(measured, thing, size, asked.fixed, progress)
        return code_tables.write(made, folder)
    asked.require_papers_own()
    document = tables.profiles(
        [read_thing(source) for source in asked.scenes] or [knot()],
        size=asked.pixels(tables.SIZE),
        cuts=asked.floor or tables.CUTS,
        fixed=asked.fixed,
        seed=asked.seed,
        progress=progress,
    )
    return tables.write(document, folder)


def _figures(asked: Asked, folder: Path, progress: Progress) -> list[Path]:
    makers: Makers
    if asked.methods == [editing_session.METHOD]:
        makers = _of_editing(asked, progress)
    elif asked.methods == [code_stage.METHOD]:
        makers = _of_codes(asked, progress)
    else:
        asked.require_papers_own()
        makers = _of_papers_own(asked, progress)
    for number in asked.figures:
        if number not in makers:
            known = ", ".join(map(str, makers))
            raise InputError(f"{number} is not made; there are {known}", field="figure")
    return [
        path
        for number in asked.figures
        for path in contact_sheet.write(makers[number](), folder, f"figure-{number}")
    ]


def _of_papers_own(asked: Asked, progress: Progress) -> Makers:
    shoot = figures.Shoot(
        asked.thing(),
        asked.pixels(figures.SIZE),
        cuts=asked.floor or figures.CUTS,
        fixed=asked.fixed,
        reference_error=asked.error(figures.REFERENCE_ERROR),
        progress=progress,
    )
    return {number: partial(make, shoot) for number, make in figures.FIGURES.items()}


def _of_editing(asked: Asked, progress: Progress) -> Makers:
    if asked.scenes:
        raise InputError("these figures are of the built-in scenes", field="SCENE")
    usual = editing_session.WIDTH
    session = editing_session.Session(
        width=asked.pixels((usual, usual))[0],
        fixed=asked.fixed,
        reference_error=asked.error(editing_session.REFERENCE_ERROR),
        progress=progress,
    )
    return {number: partial(make, session) for number, make in editing_figures.FIGURES.items()}


def _of_codes(asked: Asked, progress: Progress) -> Makers:
    thing, materials = _objects_and_materials(asked)
    size, fixed = asked.pixels(code_figures.SIZE), asked.fixed
    shoot = code_figures.Shoot(
        thing, materials or code_stage.measured_by_name([]), size, fixed, progress
    )
    return {number: partial(make, shoot) for number, make in code_figures.FIGURES.items()}


def _report(asked: Asked, folder: Path, progress: Progress) -> list[Path]:
    with needs_extra("peers"):
        return write_report(asked.scenes, folder, rivals=asked.rivals, progress=progress)


def _objects_and_materials(asked: Asked) -> tuple[Thing, dict[str, Measured]]:
    """The object of the only mesh file, or a small knot; measured materials by name."""
    names = [name for name in asked.scenes if code_stage.is_material(name)]
    others = replace(asked, scenes=[name for name in asked.scenes if name not in names])
    thing = others.thing() if others.scenes else code_stage.small_knot()
    return thing, code_stage.measured_by_name(names) if names else {}


def _stability(asked: Asked, folder: Path, progress: Progress) -> list[Path]:
    if asked.scenes:
        raise InputError("this chart is of scenes of its own", field="SCENE")
    width, height = asked.pixels((stability.SIDE, stability.SIDE))
    if width != height:
        raise InputError(f"{width} x {height} is no square", field="size")
    methods = [known_method(name) for name in asked.methods]
    return stability.chart(methods, width, folder, progress)


CHARTS: dict[str, Callable[[Asked, Path, Progress], list[Path]]] = {
    "growth": _growth,
    "factorisation": _factorisation,
    "accuracy": _accuracy,
    "tables": _tables,
    "figure": _figures,
    "report": _report,
    "stability": _stability,
}
