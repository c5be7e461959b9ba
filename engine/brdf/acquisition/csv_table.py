"""Tables of measured pairs of directions in CSV files.

The first line names the columns, in any order:

    theta_i_degrees, phi_i_degrees, theta_o_degrees, phi_o_degrees, red, green, blue

Angles are from the normal and about it, of directions that both leave the surface; red, green and
blue are the BRDF in sr⁻¹ without the cosine, in linear sRGB. Other columns are not looked at, nor
are empty lines and those that start with #.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from engine.brdf.acquisition.samples import Samples, above, directions, made
from engine.errors import InputError

ANGLES = ("theta_i_degrees", "phi_i_degrees", "theta_o_degrees", "phi_o_degrees")
COLUMNS = (*ANGLES, "red", "green", "blue")


def read(path: Path) -> Samples:
    """The samples of a table.

    Rows with a direction below the surface are dropped, values below 0 become 0; both are counted.
    Raises InputError, naming file, line and column, where a column is missing or there twice, a row
    has another number of cells than the header, a cell is not a number, or there are no rows.
    """
    rows = _rows(path)
    line, names = next(rows, (0, []))
    names = [name.strip().lower() for name in names]
    for name in COLUMNS:
        if names.count(name) != 1:
            state = "twice" if name in names else "missing"
            raise InputError(
                f"the column {name!r} is {state}; the first line must name the columns "
                f"{', '.join(COLUMNS)}, in any order",
                field=f"line {max(1, line)}",
                file=str(path),
            )
    places = [names.index(name) for name in COLUMNS]
    values = [_numbers(path, line, cells, names, places) for line, cells in rows]
    if not values:
        raise InputError("the table has a header but no rows", file=str(path))
    table = np.array(values)
    theta_i, phi_i, theta_o, phi_o = np.radians(table[:, :4]).T
    wi, wo = directions(theta_i, phi_i), directions(theta_o, phi_o)
    seen = above(wi) & above(wo)
    return made(path, wi, wo, table[:, 4:], clamped=int((table[seen, 4:] < 0).sum()))


def _rows(path: Path) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of every line that is not empty or a comment."""
    # Spreadsheets put a mark of their own before the first name.
    with path.open(encoding="utf-8-sig", errors="replace", newline="") as file:
        reader = csv.reader(file)
        try:
            for cells in reader:
                if any(cell.strip() for cell in cells) and not cells[0].startswith("#"):
                    yield reader.line_num, cells
        except csv.Error as error:
            raise InputError(
                f"this is not a line of CSV: {error}",
                field=f"line {reader.line_num}",
                file=str(path),
            ) from error


def _numbers(
    path: Path, line: int, cells: list[str], names: list[str], places: list[int]
) -> list[float]:
    """The numbers of a row, in the order of COLUMNS."""
    if len(cells) != len(names):
        raise InputError(
            f"the row has {len(cells)} cells, the header {len(names)}",
            field=f"line {line}",
            file=str(path),
        )
    out = []
    for name, place in zip(COLUMNS, places, strict=True):
        try:
            value = float(cells[place])
        except ValueError:
            value = math.nan
        wrong = ""
        if not math.isfinite(value):
            wrong = f"{cells[place][:20]!r} is not a number"
        elif name.startswith("theta") and abs(value) > 180:
            wrong = f"{value:g} is no angle to the normal in degrees"
        if wrong:
            raise InputError(wrong, field=f"line {line}, column {name}", file=str(path))
        out.append(value)
    return out
