"""Draw bytes against error of BRDF codes, see `code_study`: a panel per model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from engine.measure.chart import COLOURS, GREY, line_style, machine_caption, plain_numbers, quiet
from engine.measure.code_study import FLOATS, NEURAL, OCTETS, OURS, SAME_GRID

ERRORS = {"mean": "mean relative error (%)", "light": "light in a wrong place (%)"}
SCHEMES = {
    OURS: "ours",
    SAME_GRID: "ours, the paper's grid, no symmetry",
    OCTETS: "the paper's scheme, slices of bytes",
    FLOATS: "the paper's scheme, slices of floats",
}


def draw(document: dict[str, Any]) -> Figure:
    """The figure: errors at the paper's samples, over bytes, both logarithmic."""
    families = list(dict.fromkeys(s["family"] for s in document["sources"]))
    figure = Figure(figsize=(3.2 * len(families) + 0.6, 6.6), layout="constrained")
    grid = figure.subplots(len(ERRORS), len(families), squeeze=False, sharex=True)
    for row, (error, label) in enumerate(ERRORS.items()):
        for axes, family in zip(grid[row], families, strict=True):
            sources = [s for s in document["sources"] if s["family"] == family]
            _panel(axes, sources, document, error)
            if row == 0:
                axes.set_title(f"{family}, {len(sources)} of them", fontsize=9, loc="left")
            else:
                axes.set_xlabel("bytes of the whole code")
        grid[row][0].set_ylabel(label)
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(
        handles, labels, loc="outside upper right", ncols=len(labels), fontsize=7.5, frameon=False
    )
    figure.suptitle("BRDF codes by size", fontsize=11, x=0.01, ha="left")
    caption = (
        f"{document['samples']:,} point samples; medians over parameters, thin lines the worst; "
        f"x: the paper's table 1; dotted: 675 floats; {machine_caption(document)}"
    )
    figure.supxlabel(caption, fontsize=7, color=GREY, x=0.01, ha="left")
    return figure


def curve(
    sources: Sequence[dict[str, Any]], scheme: str, error: str
) -> list[tuple[int, float, float]]:
    """(bytes that are allowed, median, worst error) at the paper's samples.

    Of a size each source has its best grid; sizes that not all sources have are left out.
    """
    points = []
    sizes = sorted({c["at_most"] for s in sources for c in s["codes"]})
    for size in sizes:
        best = [best_of(source, scheme, size) for source in sources]
        if all(best):
            errors = [code["at_papers"][error] for code in best if code]
            points.append((size, float(np.median(errors)), float(max(errors))))
    return points


def best_of(source: dict[str, Any], scheme: str, size: int) -> dict[str, Any] | None:
    """The code of at most so many bytes that is nearest at the paper's samples."""
    fitting = [c for c in source["codes"] if c["scheme"] == scheme and c["at_most"] == size]
    return min(fitting, key=lambda code: float(code["at_papers"]["mean"]), default=None)


def _panel(
    axes: Axes, sources: Sequence[dict[str, Any]], document: dict[str, Any], error: str
) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    axes.axvline(NEURAL, color=GREY, linewidth=0.9, linestyle=":")
    for number, (scheme, label) in enumerate(SCHEMES.items()):
        points = curve(sources, scheme, error)
        if points:
            size, median, worst = (np.array(column) for column in zip(*points, strict=True))
            axes.plot(size, 100 * median, **line_style(number), label=label)
            axes.plot(size, 100 * worst, color=COLOURS[number], linewidth=0.6)
    paper = document["paper"].get(sources[0]["family"])
    if paper is not None and error == "mean":
        sizes = [document["sample_bytes"] / ratio for ratio in document["ratios"]]
        percent = [100 * value for value in paper["mean"]]
        axes.plot(sizes, percent, "x", color="black", markersize=7, markeredgewidth=1.6)
    plain_numbers(axes.yaxis)
    quiet(axes)
