"""Files of the MERL database: isotropic BRDFs on a grid about the half vector.

Matusik, Pfister, Brand and McMillan 2003. Three int32, the dimensions 90, 90, 180; then float64 in
three planes, red, green and blue, each in the order θ_h, θ_d, φ_d, little-endian. With θ_h, θ_d in
[0, π/2] and φ_d in [0, π), which reciprocity repeats, cell (i, j, k) lies about

    θ_h = ((i + ½) / 90)² π/2      θ_d = (j + ½)° π/180      φ_d = (k + ½)° π/180

The published look-up takes the cell that a pair falls into, so a number stands for the middle of
its cell; between the middles it is interpolated here. Values below 0 mark cells that were not
measured.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import distance_transform_edt

from engine.brdf.acquisition.pairs import half_and_difference
from engine.brdf.acquisition.report import Report
from engine.brdf.acquisition.survey import energy, unlike_reverses
from engine.errors import InputError

SHAPE = (90, 90, 180)
SCALES = (1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0)
HEAD = 12  # bytes
AROUND = 20  # cells across φ_d = 0 in which a hole looks for its nearest value


@dataclass(frozen=True, eq=False)
class Merl:
    """A `Measurement` on a grid.

    name    of the material
    table   (90, 90, 180, 3) float64, BRDF in sr⁻¹, linear RGB, ≥ 0
    filled  cells above the surface that held no value
    """

    name: str
    table: NDArray[np.float64]
    filled: int

    @property
    def isotropic(self) -> bool:
        """Its grid knows no others."""
        return True

    @cached_property
    def report(self) -> Report:
        """What the table holds. It covers all pairs; only its holes are extrapolated."""
        reflected = energy(self.evaluate, True)
        cells = int(_above_surface().sum())
        return Report(
            self.name,
            True,
            cells - self.filled,
            reflected,
            reflected,
            filled=self.filled,
            coverage=1.0 - self.filled / cells,
            unlike_after=unlike_reverses(self.evaluate),
        )

    def evaluate(self, wi: NDArray[np.float64], wo: NDArray[np.float64]) -> NDArray[np.float64]:
        """BRDF (q, 3) of pairs (q, 3), (q, 3); see `Measurement`."""
        h, e, cosine = half_and_difference(wi, wo)
        slope = np.hypot(h[:, 0], h[:, 1])
        theta_h = np.arctan2(slope, h[:, 2])
        theta_d = np.arctan2(np.hypot(e[:, 0], e[:, 1]), cosine)
        # Turned as h is, so that it leans along x.
        phi_d = np.arctan2(
            h[:, 0] * e[:, 1] - h[:, 1] * e[:, 0], h[:, 0] * e[:, 0] + h[:, 1] * e[:, 1]
        )
        x = SHAPE[0] * np.sqrt(theta_h / (np.pi / 2)) - 0.5
        y = SHAPE[1] * theta_d / (np.pi / 2) - 0.5
        z = SHAPE[2] * (phi_d / np.pi % 1.0) - 0.5
        out = np.zeros((len(wi), 3))
        for i, u in _both_sides(np.clip(x, 0, SHAPE[0] - 1)):
            for j, v in _both_sides(np.clip(y, 0, SHAPE[1] - 1)):
                for k, w in _both_sides(z):
                    cell = (
                        np.minimum(i, SHAPE[0] - 1),
                        np.minimum(j, SHAPE[1] - 1),
                        k % SHAPE[2],
                    )
                    out += (u * v * w)[:, None] * self.table[cell]
        out[(wi[:, 2] < 0) | (wo[:, 2] < 0)] = 0.0
        return out


def read(path: Path) -> Merl:
    """The table of a file, its holes filled.

    Raises InputError, naming the file, where its dimensions are others, it is cut short or too
    long, holds a value that is not finite, or no value at all.
    """
    data = path.read_bytes()
    found = tuple(np.frombuffer(data[:HEAD], "<i4").tolist()) if len(data) >= HEAD else ()
    if found != SHAPE:
        raise InputError(
            f"a MERL file starts with the dimensions {_times(SHAPE)}, this with "
            f"{_times(found) if found else 'fewer than three numbers'}",
            file=str(path),
        )
    wanted = HEAD + 8 * 3 * int(np.prod(SHAPE))
    if len(data) != wanted:
        state = "is cut short" if len(data) < wanted else "goes on after its end"
        raise InputError(
            f"the file {state}: {len(data):,} bytes where a MERL file has {wanted:,}",
            file=str(path),
        )
    planes = np.frombuffer(data[HEAD:], "<f8").reshape(3, *SHAPE)
    if not np.isfinite(planes).all():
        count = int((~np.isfinite(planes)).sum())
        raise InputError(f"{count} values are NaN or infinite", file=str(path))
    known = (planes >= 0).all(axis=0)
    above = _above_surface()
    # What stands in cells below the surface is no measurement, and the horizon must not see it.
    holes = ~known | ~above
    if holes.all():
        raise InputError(
            "all values are below 0, which marks what was not measured", file=str(path)
        )
    table = np.moveaxis(planes * np.reshape(SCALES, (3, 1, 1, 1)), 0, -1)
    return Merl(path.stem, _filled(table, holes), int((~known & above).sum()))


def _times(shape: tuple[int, ...]) -> str:
    return " x ".join(str(n) for n in shape)


def _filled(table: NDArray[np.float64], holes: NDArray[np.bool_]) -> NDArray[np.float64]:
    """The table with every hole given the value of the nearest cell that has one."""
    around = ((0, 0), (0, 0), (AROUND, AROUND))
    wrapped = np.pad(holes, around, mode="wrap")
    i, j, k = distance_transform_edt(wrapped, return_distances=False, return_indices=True)
    inside = (slice(None), slice(None), slice(AROUND, -AROUND))
    return np.ascontiguousarray(table[i[inside], j[inside], (k[inside] - AROUND) % SHAPE[2]])


def centres() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Pairs (90·90·180, 3) in the middles of all cells, h leaning along x; some lie below z = 0."""
    i, j, k = (np.arange(n) + 0.5 for n in SHAPE)
    theta_h = (i / SHAPE[0])[:, None, None] ** 2 * (np.pi / 2)
    theta_d = (j / SHAPE[1])[:, None] * (np.pi / 2)
    phi_d = k / SHAPE[2] * np.pi
    pair = []
    for turn in (0.0, np.pi):
        x, y = np.sin(theta_d) * np.cos(phi_d + turn), np.sin(theta_d) * np.sin(phi_d + turn)
        z = np.cos(theta_d)
        w = np.broadcast_arrays(
            x * np.cos(theta_h) + z * np.sin(theta_h), y, z * np.cos(theta_h) - x * np.sin(theta_h)
        )
        pair.append(np.stack(w, axis=-1).reshape(-1, 3))
    return pair[0], pair[1]


def _above_surface() -> NDArray[np.bool_]:
    """Which cells (90, 90, 180) have both directions of their middle above the surface."""
    wi, wo = centres()
    return ((wi[:, 2] > 0) & (wo[:, 2] > 0)).reshape(SHAPE)


def _both_sides(
    x: NDArray[np.float64],
) -> tuple[tuple[NDArray[np.intp], NDArray[np.float64]], ...]:
    """The cells (q,) before and after places (q,), with their weights."""
    low = np.floor(x)
    part = x - low
    first = low.astype(np.intp)
    return (first, 1.0 - part), (first + 1, part)
