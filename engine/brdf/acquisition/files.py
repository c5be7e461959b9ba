"""Measured materials from files, whatever their format."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np

from engine.brdf.acquisition import csv_table, goniometer, merl
from engine.brdf.acquisition.completion import complete
from engine.brdf.acquisition.isotropy import is_isotropic
from engine.brdf.acquisition.measurement import Measurement
from engine.brdf.acquisition.samples import Samples
from engine.errors import InputError

SCATTERED: dict[str, Callable[[Path], Samples]] = {".brdf": goniometer.read, ".csv": csv_table.read}
GRIDDED: dict[str, Callable[[Path], Measurement]] = {".binary": merl.read}


def read(path: Path) -> Measurement:
    """The measurement in a file: `merl`, `goniometer` or `csv_table`, by its extension.

    Where the extension says nothing, the start of the file does. Raises InputError, naming the file
    and the line, where it is missing, damaged or of none of these formats.
    """
    if not path.is_file():
        raise InputError("there is no such file", file=str(path))
    suffix = path.suffix.lower()
    kind = suffix if suffix in SCATTERED or suffix in GRIDDED else _kind_of(path)
    if kind in GRIDDED:
        return GRIDDED[kind](path)
    if kind in SCATTERED:
        samples = SCATTERED[kind](path)
        return complete(samples, is_isotropic(samples))
    raise InputError(
        "this is no file of a measured material: known are MERL's .binary, a goniometer's .brdf "
        "and tables in .csv",
        file=str(path),
    )


def _kind_of(path: Path) -> str:
    """The extension that a file should have, by what it starts with; "" for none."""
    with path.open("rb") as file:
        start = file.read(4096)
    if start[:12] == np.array(merl.SHAPE, "<i4").tobytes():
        return ".binary"
    text = start.decode("utf-8", errors="replace").lower()
    lines = [line.strip() for line in text.splitlines()]
    first = next((line for line in lines if line and not line.startswith("#")), "")
    if csv_table.ANGLES[0] in first:
        return ".csv"
    return ".brdf" if first.isdigit() else ""
