"""Draw an accuracy study: a panel per setting, a line per material; and its tables, in Markdown."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from engine.measure.accuracy import SWEEPS, TRANSPORTS
from engine.measure.chart import (
    GREY,
    line_style,
    machine_caption,
    plain_numbers,
    quiet,
    write_figure,
)
from engine.measure.document import table

Point = dict[str, Any]
BOUNCES = "bounces"
LABELS = {
    "terms": "terms K",
    "coefficients": "wavelets $N_l$",
    "light_texels": "texels along a face\nof the light's cube map",
    "gather_texels": "texels along a face\nof the gathering cube map",
    BOUNCES: "bounces followed",
}
PATHS = {"direct": "direct light", BOUNCES: "all light"}
SHOWN = 0.1  # per cent: errors below are drawn there, since a logarithm has no place for 0
APART = 0.05  # between the ranges of two materials, parts of the way to the next value


def write(document: dict[str, Any], folder: Path) -> list[Path]:
    """Write accuracy.svg, .png, .json and .md into a folder; returns their paths."""
    paths = write_figure(draw(document), document, folder, "accuracy")
    paths.append(folder / "accuracy.md")
    paths[-1].write_text(tables(document))
    return paths


def draw(document: dict[str, Any]) -> Figure:
    """The figure; the error is the median over the environments, bars are their range."""
    panels = [*SWEEPS, BOUNCES]
    figure = Figure(figsize=(2.55 * len(panels) + 0.5, 4.4), layout="constrained")
    grid = figure.subplots(1, len(panels), sharey=True)
    for axes, knob in zip(grid, panels, strict=True):
        _draw_panel(axes, document, knob)
    grid[0].set_ylabel("relative L² error without edges (%)")
    handles, names = grid[-1].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper right", ncols=len(names), frameon=False)
    title = f"{document['method']} against the path tracer"
    figure.suptitle(title, fontsize=11, x=0.01, ha="left")
    figure.supxlabel(_caption(document), fontsize=7, color=GREY, x=0.01, ha="left")
    return figure


def _draw_panel(axes: Axes, document: dict[str, Any], knob: str) -> None:
    axes.set_yscale("log")
    lines = {name: _line(document, name, knob) for name in document["materials"]}
    values = sorted({value for line in lines.values() for value, _ in line})
    for number, (name, line) in enumerate(lines.items()):
        # Values stand side by side at equal distances, the ranges of materials beside each other.
        shift = APART * (number - (len(lines) - 1) / 2)
        x = [values.index(value) + shift for value, _ in line]
        low, middle, high = (
            np.maximum(SHOWN, [100 * f(errors) for _, errors in line])
            for f in (np.min, np.median, np.max)
        )
        style = line_style(number)
        axes.plot(x, middle, **style, label=name)
        axes.vlines(x, low, high, color=style["color"], linewidth=0.9, alpha=0.55)
    where = BOUNCES if knob == BOUNCES else SWEEPS[knob][0]
    floors = [
        r["floor"]
        for r in document["references"]
        if (r["max_bounces"] is None if knob == BOUNCES else r["transport"] == where)
    ]
    # Errors below are lost in the noise of the references, on the whole.
    height = 100 * float(np.median(floors))
    axes.axhline(height, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)))
    axes.set_xticks(range(len(values)), [str(value) for value in values], fontsize=8)
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel(LABELS[knob], fontsize=9)
    axes.set_title(f"against {PATHS.get(where, where)}", fontsize=8, color=GREY, loc="left")
    plain_numbers(axes.yaxis)
    axes.tick_params(axis="y", labelsize=8)
    quiet(axes)


def _line(document: dict[str, Any], material: str, knob: str) -> list[tuple[Any, list[float]]]:
    """(value, errors of all environments) of a material, by value."""
    points = [p for p in document["points"] if p["material"] == material]
    if knob == BOUNCES:
        found = [p for p in _defaults(points) if not TRANSPORTS[p["transport"]].alone]
        kind = "of_all_bounces"
    else:
        found = [p for p in points if p["transport"] == SWEEPS[knob][0] and p["knob"] in ("", knob)]
        kind = "relative_l2"
    line = [(p["settings"][knob], [e[kind] for e in p["errors"].values()]) for p in found]
    return sorted(line, key=lambda entry: entry[0])


def _caption(document: dict[str, Any]) -> str:
    staged = list(document["vertices"])[-1]
    return (
        f"{staged}, {document['width']} x {document['height']}; medians over "
        f"{len(document['environments'])} environments, bars their range; references to "
        f"{100 * document['reference_error']:g} %, noise taken out; what it hides lies below the "
        f"dashes; {machine_caption(document)}"
    )


def tables(document: dict[str, Any]) -> str:
    """Errors at the defaults in per cent, material by material, as Markdown."""
    settings = _defaults(document["points"])[0]["settings"]
    head = [
        f"# Accuracy of `{document['method']}`",
        "",
        f"Relative L2 error in per cent, {document['width']} x {document['height']} pixels, edges "
        "and background left out. "
        + ", ".join(f"{name}: {count:,} vertices" for name, count in document["vertices"].items())
        + f". K = {settings['terms']}, N_l = {settings['coefficients']}. "
        + machine_caption(document)
        + ".",
    ]

    def block(title: str, kind: str, keep: Callable[[Point], bool]) -> list[str]:
        rows = [p for p in _defaults(document["points"]) if keep(p)]
        return ["", f"## {title}", "", *_table(document["environments"], rows, kind)]

    def staged(point: Point) -> bool:
        return not TRANSPORTS[point["transport"]].alone

    return "\n".join(
        [
            *head,
            *block("Against light that bounces as often", "relative_l2", lambda p: True),
            *block("The same, the object's own pixels", "object", staged),
            *block("Against light that is followed to its end", "of_all_bounces", staged),
            "",
        ]
    )


def _table(environments: Sequence[str], points: Sequence[Point], kind: str) -> list[str]:
    rows = []
    for point in points:
        errors = [point["errors"][name][kind] for name in environments]
        # Where no pixel shows the object there is no error.
        errors.append(None if None in errors else float(np.median(errors)))
        cells = ["-" if error is None else f"{100 * error:.1f}" for error in errors]
        rows.append([point["material"], point["transport"], *cells])
    return table(["material", "light", *environments, "median"], rows, names=2)


def _defaults(points: Sequence[Point]) -> list[Point]:
    return [p for p in points if not p["knob"]]
