"""Pictures side by side with what they are and how far off they are, as one PNG."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from engine.measure.chart import GREY, machine_caption
from engine.measure.document import write_json
from engine.measure.false_colour import false_colour
from engine.numerics.display import to_srgb

WIDE = 2.0  # inches of a picture
Image = NDArray[np.float32]


@dataclass(frozen=True)
class Tile:
    """A picture as it is shown, (h, w, 3) in [0, 1], and a line or two below it."""

    image: NDArray[np.float64]
    caption: str


@dataclass(frozen=True)
class Row:
    """Pictures of one thing, whose name stands at the left; None leaves a place empty."""

    name: str
    tiles: Sequence[Tile | None]


@dataclass(frozen=True)
class Sheet:
    """Rows of equally many pictures, a title, what is to be seen, and the numbers behind it."""

    title: str
    caption: str
    rows: Sequence[Row]
    document: dict[str, Any]


def picture(image: Image, exposure: float, caption: str) -> Tile:
    """A tile of linear radiance (h, w, 3), at an exposure in stops."""
    return Tile(to_srgb(image, exposure), caption)


def difference(
    image: Image, reference: Image, mask: NDArray[np.bool_], full: float, caption: str
) -> Tile:
    """A tile of where a picture is too bright, red, and too dark, blue; see `false_colour`."""
    return Tile(false_colour(image, reference, mask, full), caption)


def draw(sheet: Sheet) -> Figure:
    """The figure; all its pictures are of one shape."""
    columns = max(len(row.tiles) for row in sheet.rows)
    height, width = next(t for row in sheet.rows for t in row.tiles if t).image.shape[:2]
    figure = Figure(
        figsize=(WIDE * columns + 0.4, (WIDE * height / width + 0.36) * len(sheet.rows) + 0.7),
        layout="constrained",
    )
    grid = figure.subplots(len(sheet.rows), columns, squeeze=False)
    for cells, row in zip(grid, sheet.rows, strict=True):
        for axes, tile in zip(
            cells, [*row.tiles, *[None] * (columns - len(row.tiles))], strict=True
        ):
            axes.set_xticks([])
            axes.set_yticks([])
            axes.spines[:].set_visible(False)
            if tile is not None:
                axes.imshow(tile.image, interpolation="nearest")
                axes.set_xlabel(tile.caption, fontsize=7.5)
        cells[0].set_ylabel(row.name, fontsize=8.5)
    figure.suptitle(sheet.title, fontsize=11, x=0.01, ha="left")
    caption = f"{sheet.caption}\n{machine_caption(sheet.document)}"
    figure.supxlabel(caption, fontsize=7, color=GREY, x=0.01, ha="left", multialignment="left")
    return figure


def write(sheet: Sheet, folder: Path, name: str) -> list[Path]:
    """Write a sheet as PNG and its numbers as JSON; returns their paths."""
    numbers, image = write_json(sheet.document, folder, name), folder / f"{name}.png"
    draw(sheet).savefig(image, dpi=150, metadata={"Software": None})
    return [image, numbers]
