"""Tables in CSV files: what is read, and what is said of bad ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from engine.brdf.acquisition import csv_table
from engine.brdf.acquisition.csv_table import COLUMNS
from engine.errors import InputError

HEADER = ",".join(COLUMNS)
ROW = "30,0,45,180,0.1,0.2,0.3"


def table(folder: Path, *lines: str) -> Path:
    path = folder / "table.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


def test_rows_become_directions_and_colours(tmp_path: Path) -> None:
    samples = csv_table.read(table(tmp_path, HEADER, ROW, "", "# a remark", "0,0,90,10,1,1,1"))
    s = np.sin(np.pi / 4)
    np.testing.assert_allclose(samples.wi, [[0.5, 0, np.sqrt(0.75)], [0, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(samples.wo[0], [-s, 0, s], atol=1e-12)
    np.testing.assert_array_equal(samples.rgb, [[0.1, 0.2, 0.3], [1, 1, 1]])


def test_columns_in_any_order(tmp_path: Path) -> None:
    """Named in any case, with a spreadsheet's mark before them, with others among them."""
    values = dict(zip(COLUMNS, ROW.split(","), strict=True)) | {"remark": "x, y"}
    names = sorted(values, reverse=True)
    header = "\ufeff" + ", ".join(name.upper() for name in names)
    row = ",".join(f'"{values[name]}"' for name in names)
    mixed = csv_table.read(table(tmp_path, header, row))
    plain = csv_table.read(table(tmp_path, HEADER, ROW))
    for field in ("wi", "wo", "rgb"):
        np.testing.assert_array_equal(getattr(mixed, field), getattr(plain, field))


def test_noise_and_rows_below_the_surface(tmp_path: Path) -> None:
    below, noisy = "95,0,45,0,1,1,-1", "30,0,45,0,-0.1,0.2,-0.3"
    samples = csv_table.read(table(tmp_path, HEADER, ROW, below, noisy))
    assert (samples.dropped, samples.clamped) == (1, 2)
    np.testing.assert_array_equal(samples.rgb[1], [0, 0.2, 0])


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], "line 1: the column 'theta_i_degrees' is missing"),
        ([ROW], "line 1: the column 'theta_i_degrees' is missing; the first line must name"),
        ([HEADER.replace("phi_o_degrees", "phi_o"), ROW], "column 'phi_o_degrees' is missing"),
        ([HEADER + ",red", ROW + ",1"], "line 1: the column 'red' is twice"),
        ([HEADER], "the table has a header but no rows"),
        ([HEADER, ROW, "30,0,45"], "line 3: the row has 3 cells, the header 7"),
        ([HEADER, ROW + ",1"], "line 2: the row has 8 cells, the header 7"),
        ([HEADER, "", ROW.replace("0.2", "dark")], "line 3, column green: 'dark' is not a number"),
        ([HEADER, ROW.replace("0.2", "nan")], "line 2, column green: 'nan' is not a number"),
        ([HEADER, ROW.replace("0.2", "")], "line 2, column green: '' is not a number"),
        ([HEADER, "230" + ROW[2:]], "line 2, column theta_i_degrees: 230 is no angle"),
        ([HEADER, "95" + ROW[2:]], "no row has both of its directions above"),
    ],
)
def test_bad_tables(tmp_path: Path, lines: list[str], message: str) -> None:
    path = table(tmp_path, *lines)
    with pytest.raises(InputError, match=message) as error:
        csv_table.read(path)
    assert error.value.file == str(path)


def test_a_cell_without_end(tmp_path: Path) -> None:
    """The csv module has a limit of its own."""
    path = table(tmp_path, HEADER, '"' + "1" * 200_000)
    with pytest.raises(InputError, match="line 2: this is not a line of CSV"):
        csv_table.read(path)
