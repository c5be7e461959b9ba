"""Text files of a goniometer: scattered pairs of directions, each with a spectrum.

    # comments, anywhere, each a line of its own
    31                                     number of wavelengths
    400 410 420 ... 700                    the wavelengths in nm, ascending, on any number of lines
    theta_i phi_i theta_s phi_s s1 ... s31     one row a line: radians, then BRDF in sr⁻¹

The azimuths are those of directions that both leave the surface: a mirror sends phi to phi + π.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.brdf.acquisition.samples import Samples, above, directions, made
from engine.brdf.acquisition.spectrum import linear_srgb
from engine.errors import InputError

ANGLES = 4


def read(path: Path) -> Samples:
    """The samples of a file in linear sRGB.

    Rows with a direction below the surface are dropped, values below 0, which noise makes, become
    0; both are counted. Raises InputError, naming file and line, where the file is cut short, a row
    has the wrong number of columns, something is not a number, the wavelengths do not ascend, or
    there are no rows.
    """
    lines = _Lines(path)
    wavelengths = _wavelengths(lines)
    rows = _rows(lines, ANGLES + len(wavelengths))
    theta_i, phi_i, theta_s, phi_s = rows[:, :ANGLES].T
    wi, wo = directions(theta_i, phi_i), directions(theta_s, phi_s)
    seen = above(wi) & above(wo)
    spectra = rows[:, ANGLES:]
    rgb = linear_srgb(wavelengths, np.maximum(spectra, 0.0))
    return made(
        path,
        wi,
        wo,
        rgb,
        clamped=int((spectra[seen] < 0).sum()),
        out_of_gamut=int((rgb[seen] < 0).any(axis=1).sum()),
    )


class _Lines:
    """Lines of numbers of a file, without comments and empty lines, and errors that name them."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.number = 0
        # What is no text becomes something that is no number, and is named as such.
        self._text = path.read_text(encoding="utf-8", errors="replace").splitlines()

    def __iter__(self) -> Iterator[list[float]]:
        while self.number < len(self._text):
            self.number += 1
            line = self._text[self.number - 1].strip()
            if line and not line.startswith("#"):
                yield [self._value(word) for word in line.split()]

    def error(self, message: str) -> InputError:
        """What to raise about the line read last."""
        return InputError(message, field=f"line {self.number}", file=str(self.path))

    def is_last(self) -> bool:
        """Whether nothing but comments follows."""
        rest = (line.strip() for line in self._text[self.number :])
        return not any(line and not line.startswith("#") for line in rest)

    def _value(self, word: str) -> float:
        try:
            value = float(word)
        except ValueError:
            raise self.error(f"{word[:20]!r} is not a number") from None
        if not math.isfinite(value):
            raise self.error(f"{word!r} is not a finite number")
        return value


def _wavelengths(lines: _Lines) -> NDArray[np.float64]:
    """The wavelengths (k,) in nm from the head of a file."""
    head = next(iter(lines), None)
    if head is None:
        raise InputError("the file holds no numbers", file=str(lines.path))
    if len(head) != 1 or head[0] < 1 or head[0] != int(head[0]):
        found = " ".join(f"{value:g}" for value in head[:5])
        raise lines.error(f"the number of wavelengths should stand here alone, not {found!r}")
    count = int(head[0])
    found_nm: list[float] = []
    for values in lines:
        found_nm += values
        if len(found_nm) > count:
            raise lines.error(f"there are more wavelengths than the {count} announced")
        if len(found_nm) == count:
            break
    else:
        raise lines.error(f"the file ends after {len(found_nm)} of {count} wavelengths")
    if any(a >= b for a, b in pairwise(found_nm)) or found_nm[0] <= 0:
        raise lines.error("the wavelengths must ascend, in nm")
    return np.array(found_nm)


def _rows(lines: _Lines, columns: int) -> NDArray[np.float64]:
    """All rows (n, columns) after the head."""
    rows: list[list[float]] = []
    for row in lines:
        if len(row) < columns and lines.is_last():
            raise lines.error(
                f"the file is cut short: its last row has {len(row)} of {columns} numbers"
            )
        if len(row) != columns:
            raise lines.error(
                f"a row has {columns} numbers, {ANGLES} angles and {columns - ANGLES} values; "
                f"this has {len(row)}"
            )
        if max(abs(row[0]), abs(row[2])) > math.pi:
            raise lines.error(
                f"an angle to the normal of {max(abs(row[0]), abs(row[2])):g} is more than π: "
                "angles are in radians"
            )
        rows.append(row)
    if not rows:
        raise InputError("the file has wavelengths but no rows", file=str(lines.path))
    return np.array(rows)
