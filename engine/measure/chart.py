"""Draw speed against accuracy from a sweep's document: SVG, PNG, and the numbers themselves.

Readable in print and to the colour-blind: the palette of Okabe and Ito, another marker per line,
words beside the lines in place of a legend.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from engine.measure.document import write_json

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#000000")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")
GREY = "#666666"

Point = dict[str, Any]


def write_chart(document: dict[str, Any], folder: Path) -> list[Path]:
    """Write chart.svg, chart.png and chart.json into a folder; returns their paths."""
    return write_figure(draw(document), document, folder, "chart")


def write_figure(figure: Figure, document: dict[str, Any], folder: Path, name: str) -> list[Path]:
    """Write a figure as SVG and PNG, and the numbers behind it as JSON; returns their paths."""
    numbers = write_json(document, folder, name)
    paths = [folder / f"{name}.svg", folder / f"{name}.png", numbers]
    # A fixed salt and no date: the same numbers give the same file.
    with matplotlib.rc_context({"svg.hashsalt": "relight", "svg.fonttype": "none"}):
        figure.savefig(paths[0], metadata={"Date": None})
    figure.savefig(paths[1], dpi=200, metadata={"Software": None})
    return paths


def draw(document: dict[str, Any]) -> Figure:
    """The figure: frame time in milliseconds against relative error in percent, both log."""
    figure = Figure(figsize=(8.0, 5.4), layout="constrained")
    axes = figure.add_subplot()
    lines = _lines(document)
    _set_up_axes(axes, document)
    _draw_front(axes, document)
    _draw_floor(axes, document)
    labels: list[tuple[float, float, str, str]] = []
    for number, ((method, knob), points) in enumerate(lines.items()):
        colour = COLOURS[number % len(COLOURS)]
        x, y = [_ms(p) for p in points], [_percent(p, document) for p in points]
        axes.plot(x, y, **line_style(number, size=6))
        name = knob if len({m for m, _ in lines}) == 1 else f"{method} {knob}"
        # The line's name stands at its largest value that is not the default.
        named = max((k for k, p in enumerate(points) if p["knob"]), default=0)
        for k, point in enumerate(points):
            value = _short(point["settings"][knob])
            if point["knob"]:
                text = f"{name} = {value}" if k == named else value
                labels.append((x[k], y[k], text, colour))
    for point in document["points"]:
        if not point["knob"]:
            x_, y_ = _ms(point), _percent(point, document)
            axes.plot(x_, y_, "o", markersize=11, markerfacecolor="none", markeredgecolor="black")
            labels.append((x_, y_, "defaults", "black"))
    _place_labels(figure, axes, labels)
    axes.set_title(_title(document), loc="left", fontsize=11)
    figure.supxlabel(_caption(document), fontsize=7, color=GREY, x=0.01, ha="left")
    return figure


def _lines(document: dict[str, Any]) -> dict[tuple[str, str], list[Point]]:
    """The points of every swept setting by its value; the defaults belong to every line."""
    points = document["points"]
    lines: dict[tuple[str, str], list[Point]] = {}
    for point in points:
        if point["knob"]:
            lines.setdefault((point["method"], point["knob"]), []).append(point)
    for (method, knob), line in lines.items():
        line += [p for p in points if p["method"] == method and not p["knob"]]
        line.sort(key=lambda p, knob=knob: p["settings"][knob])  # type: ignore[misc]
    if not lines:
        lines = {(p["method"], next(iter(p["settings"]))): [p] for p in points}
    return lines


def _set_up_axes(axes: Axes, document: dict[str, Any]) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.set_xlabel("edit to linear frame, median (ms)")
    axes.set_ylabel("relative L² error without edges (%)")
    for axis in (axes.xaxis, axes.yaxis):
        plain_numbers(axis)
    quiet(axes)
    x = [_ms(p) for p in document["points"]]
    y = [_percent(p, document) for p in document["points"]]
    axes.set_xlim(min(x) / 1.35, max(x) * 1.6)
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


def _draw_front(axes: Axes, document: dict[str, Any]) -> None:
    """A broad grey stair below which no setting comes."""
    front = sorted((p for p in document["points"] if p["pareto"]), key=_ms)
    x, y = [_ms(p) for p in front], [_percent(p, document) for p in front]
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


def _place_labels(
    figure: Figure, axes: Axes, labels: Sequence[tuple[float, float, str, str]]
) -> None:
    """Write every label beside its point, at the first place where none stands yet."""
    figure.draw_without_rendering()
    points = [axes.transData.transform((x, y)) for x, y, _, _ in labels]
    taken = [(px - 5, py - 5, px + 5, py + 5) for px, py in points]
    for (x, y, text, colour), (px, py) in zip(labels, points, strict=True):
        width, height = 5.0 * len(text) * figure.dpi / 72, 9.0 * figure.dpi / 72
        left_of = -7 - 4.6 * len(text)
        places = [(7, -3), (7, 6), (7, -13), (-3, 9), (-3, -16), (left_of, 5)]
        # Where lines crowd, farther off.
        places += [(x, y) for y in (-14, 16, -26, 28, -38, 40, -50, 52) for x in (left_of, 7)]
        for dx, dy in places:
            left, low = px + dx * figure.dpi / 72, py + dy * figure.dpi / 72
            box = (left, low, left + width, low + height)
            if not any(_overlap(box, other) for other in taken):
                break
        taken.append(box)
        axes.annotate(
            text,
            (x, y),
            xytext=(dx, dy),
            textcoords="offset points",
            fontsize=8,
            color=colour,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.6},
        )


def _overlap(a: tuple[float, ...], b: tuple[float, ...]) -> bool:
    return a[0] < b[2] and b[0] < a[2] and a[1] < b[3] and b[1] < a[3]


def _ms(point: Point) -> float:
    return 1000 * float(point["frame_seconds"]["median"])


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
