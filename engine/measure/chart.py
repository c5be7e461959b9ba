"""Draw speed against accuracy from a sweep's document: SVG, PNG, and the numbers themselves.

Readable in print and to the colour-blind: the palette of Okabe and Ito, another marker per line,
words beside the lines in place of a legend.
"""

from __future__ import annotations

import io
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from engine.measure.document import write_json
from engine.measure.labels import place_labels
from engine.measure.points import DEFAULTS, PLAN, RUNG
from engine.methods import METHODS

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
GREY = "#666666"
FRAME = "frame_seconds"
LEAST = 0.01  # of any cost that is drawn
WIDE = 300.0  # largest by smallest cost, beyond which only powers of ten are named
# Words, and what they count.
COSTS = {
    FRAME: ("edit to linear frame, median (ms)", 1e3),
    "bytes": ("transport (MB)", 1e-6),
    "precompute_seconds": ("precompute (s)", 1.0),
}

Point = dict[str, Any]


def write_chart(document: dict[str, Any], folder: Path) -> list[Path]:
    """Write chart.svg, chart.png and chart.json into a folder; returns their paths."""
    return write_figure(draw(document), document, folder, "chart")


def write_figure(figure: Figure, document: dict[str, Any], folder: Path, name: str) -> list[Path]:
    """Write a figure as SVG and PNG, and the numbers behind it as JSON; returns their paths."""
    numbers = write_json(document, folder, name)
    paths = [folder / f"{name}.svg", folder / f"{name}.png", numbers]
    paths[0].write_bytes(as_svg(figure))
    figure.savefig(paths[1], dpi=200, metadata={"Software": None})
    return paths


def as_svg(figure: Figure) -> bytes:
    """The figure as SVG; the same numbers give the same bytes."""
    file = io.BytesIO()
    # A fixed salt and no date.
    with matplotlib.rc_context({"svg.hashsalt": "relight", "svg.fonttype": "none"}):
        figure.savefig(file, format="svg", metadata={"Date": None})
    return file.getvalue()


def draw(document: dict[str, Any]) -> Figure:
    """The figure: relative error in percent against frame time, bytes and precompute, all log."""
    figure = Figure(figsize=(12.6, 5.4), layout="constrained")
    panels = figure.subplots(1, 3, sharey=True, width_ratios=(2.1, 1, 1))
    for axes, (cost, (words, _)) in zip(panels, COSTS.items(), strict=True):
        _set_up_axes(axes, document, cost)
        axes.set_xlabel(words)
        _draw_front(axes, document, cost)
        lines = _lines(document)
        for number, points in zip(_numbers(lines), lines.values(), strict=True):
            x = [_cost(p, cost) for p in points]
            axes.plot(x, [_percent(p, document) for p in points], **line_style(number, size=6))
        for point in document["points"]:
            if _ringed(point):
                place = _cost(point, cost), _percent(point, document)
                axes.plot(*place, "o", markersize=11, markerfacecolor="none", markeredgecolor="k")
    main = panels[0]
    main.set_ylabel("relative L² error without edges and lamps (%)")
    _draw_floor(main, document)
    _draw_others(main, document)
    place_labels(figure, main, _labels(document))
    main.set_title(_title(document), loc="left", fontsize=11)
    figure.supxlabel(_caption(document), fontsize=7, color=GREY, x=0.01, ha="left")
    return figure


def _labels(document: dict[str, Any]) -> list[tuple[float, float, str, str]]:
    """(x, y, words, colour) of every point of the first panel.

    A line's name stands at its largest value that is not the default.
    """
    labels, lines = [], _lines(document)
    for number, ((method, knob), points) in zip(_numbers(lines), lines.items(), strict=True):
        name = knob if len({m for m, _ in lines}) == 1 else f"{method} {knob}"
        named = max((k for k, p in enumerate(points) if not _ringed(p)), default=0)
        for k, point in enumerate(points):
            value = _short(point["settings"][knob])
            if not _ringed(point):
                words = method if knob == RUNG else f"{name} = {value}"
                text = words if k == named else value
                place = _cost(point, FRAME), _percent(point, document)
                labels.append((*place, text, COLOURS[number % len(COLOURS)]))
    for point in document["points"]:
        if _ringed(point):
            several = len({p["method"] for p in document["points"]}) > 1
            words = point["knob"] or (point["method"] if several else "defaults")
            labels.append((_cost(point, FRAME), _percent(point, document), words, "black"))
    for points in _others(document):
        place = _cost(points[0], FRAME), _percent(points[0], document)
        labels.append((*place, f"{points[0]['method']}, 1 sample", GREY))
        labels += [
            (_cost(p, FRAME), _percent(p, document), _short(p["settings"]["samples"]), GREY)
            for p in points[1:]
        ]
    return labels


def _others(document: dict[str, Any]) -> list[list[Point]]:
    """The points of each that needs no precompute, by their samples."""
    names = dict.fromkeys(p["method"] for p in document["others"])
    return [[p for p in document["others"] if p["method"] == name] for name in names]


def _draw_others(axes: Axes, document: dict[str, Any]) -> None:
    for number, points in enumerate(_others(document)):
        x, y = [_cost(p, FRAME) for p in points], [_percent(p, document) for p in points]
        dashes = (0, (5, 1 + 2 * number))
        axes.plot(
            x, y, marker=MARKERS[number], markersize=4, linestyle=dashes, color=GREY, linewidth=1.2
        )


def _ringed(point: Point) -> bool:
    """Whether it is of no line: the defaults, or what was planned."""
    return point["knob"] in (DEFAULTS, PLAN)


def _lines(document: dict[str, Any]) -> dict[tuple[str, str], list[Point]]:
    """The points of every swept setting by its value; the defaults belong to every line."""
    points = document["points"]
    lines: dict[tuple[str, str], list[Point]] = {}
    for point in points:
        if not _ringed(point):
            lines.setdefault((point["method"], point["knob"]), []).append(point)
    for (method, knob), line in lines.items():
        line += [p for p in points if p["method"] == method and p["knob"] == DEFAULTS]
        line.sort(key=lambda p, knob=knob: p["settings"][knob])  # type: ignore[misc]
    if not lines:
        lines = {(p["method"], next(iter(p["settings"]))): [p] for p in points}
    return lines


def _numbers(lines: Iterable[tuple[str, str]]) -> list[int]:
    """Which colour each line has: a method has the same in all charts where it is one line."""
    methods = [method for method, _ in lines]
    alone = len(set(methods)) == len(methods)
    return [list(METHODS).index(method) if alone else k for k, method in enumerate(methods)]


def _set_up_axes(axes: Axes, document: dict[str, Any], cost: str) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for axis in (axes.xaxis, axes.yaxis):
        plain_numbers(axis)
    quiet(axes)
    every = [*document["points"], *(document["others"] if cost == FRAME else [])]
    x = [_cost(p, cost) for p in every]
    y = [_percent(p, document) for p in [*document["points"], *document["others"]]]
    axes.set_xlim(min(x) / 1.35, max(x) * 1.6)
    if max(x) > WIDE * min(x):
        axes.xaxis.set_major_locator(LogLocator())
    axes.set_ylim(min([*y, 100 * _floor(document)]) / 1.3, max(y) * 1.3)


def plain_numbers(axis: Axis) -> None:
    """Labels a logarithmic axis with 1, 2, 5, 10, ... as they are."""
    axis.set_major_locator(LogLocator(subs=(1, 2, 5)))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def quiet(axes: Axes) -> None:
    """A faint grid behind the lines, and no frame."""
    axes.grid(which="major", color="#e4e4e4", linewidth=0.6)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)


def line_style(number: int, size: float = 5.0) -> dict[str, Any]:
    """Colour and marker of line `number`, as keywords of `Axes.plot`."""
    return {
        "color": COLOURS[number % len(COLOURS)],
        "marker": MARKERS[number % len(MARKERS)],
        "markersize": size,
        "linewidth": 1.4,
        "markeredgecolor": "white",
        "markeredgewidth": 0.7,
    }


def _draw_front(axes: Axes, document: dict[str, Any], cost: str) -> None:
    """A broad grey stair below which no setting comes."""
    of_front = [p for p in document["points"] if cost in p["fronts"]]
    front = sorted(of_front, key=lambda point: _cost(point, cost))
    x, y = [_cost(p, cost) for p in front], [_percent(p, document) for p in front]
    right, top = axes.get_xlim()[1], axes.get_ylim()[1]
    axes.step(
        [x[0], *x, right],
        [top, *y, y[-1]],
        where="post",
        color="#dddddd",
        linewidth=7,
        solid_joinstyle="round",
        zorder=1,
    )
    axes.annotate(
        "Pareto front",
        (right, y[-1]),
        xytext=(-4, 6),
        textcoords="offset points",
        ha="right",
        fontsize=8,
        color=GREY,
    )


def _draw_floor(axes: Axes, document: dict[str, Any]) -> None:
    """Errors below this line are lost in the noise of the references."""
    noise = 100 * _floor(document)
    axes.axhline(noise, color=GREY, linewidth=0.8, linestyle=(0, (4, 3)))
    axes.annotate(
        "what the noise of the references hides",
        (axes.get_xlim()[0], noise),
        xytext=(4, 3),
        textcoords="offset points",
        fontsize=8,
        color=GREY,
    )


def _cost(point: Point, cost: str) -> float:
    value = point["frame_seconds"]["median"] if cost == FRAME else point[cost]
    # What costs nothing has no place on a logarithm.
    return max(LEAST, COSTS[cost][1] * float(value))


def _percent(point: Point, document: dict[str, Any]) -> float:
    # An error that noise hides can come out as 0, which a logarithm has no place for.
    return 100 * max(float(point["error"][document["main_error"]]), _floor(document) / 4)


def _floor(document: dict[str, Any]) -> float:
    return float(np.sqrt(np.mean([r["floor"] ** 2 for r in document["references"]])))


def _short(value: Any) -> str:
    """65536 as 64K."""
    if isinstance(value, int) and value >= 1024 and value % 1024 == 0:
        return f"{value // 1024}K"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _title(document: dict[str, Any]) -> str:
    methods = ", ".join(dict.fromkeys(p["method"] for p in document["points"]))
    if "kinds" in document:
        methods = f"edits of {' and '.join(document['kinds'])}"
    return f"{methods} on {document['scene']}, {document['width']} x {document['height']}"


def _caption(document: dict[str, Any]) -> str:
    return (
        f"mean of {len(document['edits'])} edits unseen by the precompute (seed "
        f"{document['seed']}); {machine_caption(document)}"
    )


def machine_caption(document: dict[str, Any]) -> str:
    """Where, when and with what a document was measured."""
    machine = document["machine"]
    return (
        f"{machine['cpu']}, {machine['threads']} threads, {machine['memory_read_gb_s']:.1f} GB/s; "
        f"{document['date'][:10]}, {document['commit']}"
    )
