"""Draw how cost grows: a column for everything that grows, a row for everything that it costs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from engine.measure.chart import (
    GREY,
    line_style,
    machine_caption,
    plain_numbers,
    quiet,
    write_figure,
)
from engine.measure.document import finite, point_document, provenance
from engine.measure.growth import Grown
from engine.measure.machine import Machine
from engine.measure.points import MAIN_ERROR
from engine.measure.sweep import NEW_VIEW
from engine.scene.scene import Scene

Point = dict[str, Any]

COSTS: dict[str, dict[str, Callable[[Point], float]]] = {
    "direct_to_indirect": {
        "frame (ms)": lambda p: 1e3 * p["frame_seconds"]["median"],
        "precompute (s)": lambda p: p["precompute_seconds"],
        "transport (MB)": lambda p: 1e-6 * p["bytes"],
        "relative L² error (%)": lambda p: 100 * max(p["error"][MAIN_ERROR], p["floor"]),
    },
    "glossy_prt": {
        "light update (ms)": lambda p: 1e3 * p["frame_seconds"]["parts"]["transport"],
        "picture of a new view (ms)": lambda p: 1e3 * p["frame_seconds"]["parts"][NEW_VIEW],
        "precompute (s)": lambda p: p["precompute_seconds"],
        "transport (MB)": lambda p: 1e-6 * p["bytes"],
    },
}
"""What a point of a method costs, each in its unit; no error is drawn below what its references can
tell. The first two of `glossy_prt` are those of figure 12 of its paper."""


def write(scene: Scene, grown: Sequence[Grown], machine: Machine, folder: Path) -> list[Path]:
    """Write growth.svg, growth.png and growth.json into a folder; returns their paths."""
    document = growth_document(scene, grown, machine)
    return write_figure(draw(document), document, folder, "growth")


def growth_document(scene: Scene, grown: Sequence[Grown], machine: Machine) -> dict[str, Any]:
    """What grew as JSON."""
    camera = scene.camera
    return finite(
        {
            **provenance(),
            "machine": machine.as_dict(),
            "method": grown[0].point.method,
            "scene": scene.name,
            "width": camera.width,
            "height": camera.height,
            "triangles": len(scene.geometry.triangles),
            "main_error": MAIN_ERROR,
            "points": [
                {"size": g.size, "floor": g.floor, **point_document(g.point)} for g in grown
            ],
        }
    )


def draw(document: dict[str, Any]) -> Figure:
    """The figure: all scales are logarithmic, so that a power law is a line with its power."""
    lines: dict[str, list[Point]] = {}
    for point in document["points"]:
        lines.setdefault(point["knob"], []).append(point)
    for line in lines.values():
        line.sort(key=lambda p: p["size"])
    costs = COSTS[document["method"]]
    if len(lines) == 1:  # side by side
        figure = Figure(figsize=(2.4 * len(costs), 2.9), layout="constrained")
        grid = figure.subplots(1, len(costs), squeeze=False).T
        ends = grid
    else:
        figure = Figure(figsize=(2.3 * len(lines) + 0.8, 8.4), layout="constrained")
        grid = figure.subplots(len(costs), len(lines), sharex="col", sharey="row", squeeze=False)
        ends = grid[-1:]
    for row, (cost, of) in zip(grid, costs.items(), strict=True):
        for number, (axes, line) in enumerate(zip(row, lines.values(), strict=True)):
            size = [p["size"] for p in line]
            _draw_line(axes, size, [of(p) for p in line], number)
            if axes is row[0]:
                axes.set_ylabel(cost)
    for row in ends:
        for axes, name in zip(row, lines, strict=True):
            axes.set_xlabel(name.replace("_", " "))
    title = f"how cost grows: {TITLE.format(**document)}"
    figure.suptitle(title, fontsize=11, x=0.01, ha="left")
    caption = f"the number at a panel is the power with which it grows; {machine_caption(document)}"
    figure.supxlabel(caption, fontsize=7, color=GREY, x=0.01, ha="left")
    return figure


TITLE = "{method} on {scene}, {width} x {height}"


def _draw_line(axes: Axes, size: list[float], cost: list[float], number: int) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.plot(size, cost, **line_style(number))
    axes.set_xticks(size, [_short(value) for value in size], fontsize=7)
    axes.xaxis.set_minor_locator(NullLocator())
    plain_numbers(axes.yaxis)
    quiet(axes)
    power = growth_power(size, cost)
    if power is not None:
        axes.set_title(f"{power:+.2f}", loc="right", fontsize=8, color=GREY, pad=2)


def _short(value: float) -> str:
    """1234567 as 1.2M."""
    for unit, name in ((1e6, "M"), (1e3, "K")):
        if value >= unit:
            return (
                f"{value / unit:.2g}{name}" if value < 100 * unit else f"{value / unit:.0f}{name}"
            )
    return f"{value:g}"


def growth_power(size: list[float], cost: list[float]) -> float | None:
    """The power p of the size in cost ~ size^p, by least squares; None for fewer than two sizes."""
    if len(set(size)) < 2 or min(cost) <= 0:
        return None
    return float(np.polyfit(np.log(size), np.log(cost), 1)[0])
