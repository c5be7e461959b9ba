"""Table 1 of `wavelet_brdf` (Claustres, Barthe, Paulin 2007, §6.2): how well codes of a size fit.

The paper prints no parameters of its models, so a handful of each is swept, and the median and the
worst are told. Sizes are those of whole codes, with all that kernels need, against the samples as
RGB of float32. As in the paper samples are points, and errors are taken at the samples; where ours
lie elsewhere (`tabulate.grid_for`) also at the paper's, for which kernels interpolate.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.brdf.acquisition import of_material
from engine.brdf.base import Material
from engine.brdf.lewis import Lewis
from engine.brdf.poulin_fournier import PoulinFournier
from engine.brdf.ward import Ward
from engine.brdf.wavelet import layout
from engine.brdf.wavelet.analysis import Grid
from engine.brdf.wavelet.encoding import Encoded, Target, encode
from engine.brdf.wavelet.errors import Errors, errors_of, floors
from engine.brdf.wavelet.tabulate import BITS, Source, grid_for, incident, outgoing, tabulate
from engine.errors import InputError
from engine.measure.code_values import values_of
from engine.measure.document import finite, provenance
from engine.measure.machine import this_machine
from engine.measure.papers_code import PapersCode
from engine.methods.base import Progress, silent

DARK = (0.0, 0.0, 0.0)
FLOOR = Target().floor
RATIOS = (4, 16, 32)  # of the samples' bytes to a code's: those of the table
SMALL = (200_000, 100_000, 50_000, 25_000, 12_000, 6_000)  # bytes, beyond it
NEURAL = 2700  # bytes of 675 float32
OURS, SAME_GRID, OCTETS, FLOATS = "ours", "same grid", "paper, bytes", "paper, floats"

PAPER: dict[str, dict[str, tuple[float, ...]]] = {
    "ward": {"mean": (0.0256, 0.0402, 0.0612), "rms": (0.832, 0.840, 0.856)},
    "lewis": {"mean": (0.0174, 0.0290, 0.0373), "rms": (0.0247, 0.0417, 0.0520)},
    "poulin_fournier": {"mean": (0.121, 0.202, 0.269), "rms": (0.0291, 0.0643, 0.0847)},
    "cloth": {"mean": (0.0164, 0.02707, 0.0323), "rms": (0.00537, 0.00930, 0.0125)},
    "wood": {"mean": (0.0170, 0.0307, 0.0381), "rms": (0.00647, 0.0133, 0.0186)},
    "velvet": {"mean": (0.0522, 0.100, 0.126), "rms": (0.0155, 0.0321, 0.0418)},
}
"""The paper's table 1 at RATIOS, of slices of floats; its last three were measured."""

Family = Mapping[str, Source]


def models() -> dict[str, Family]:
    """Sources by what tells them apart, by model."""
    widths = (
        (0.5, 0.5),
        (0.5, 0.2),
        (0.3, 0.15),
        (0.2, 0.1),
        (0.1, 0.1),
        (0.1, 0.05),
        (0.05, 0.05),
    )
    ward: dict[str, Material] = {
        f"α = {x:g}, {y:g}": Ward(emission=DARK, roughness=x, roughness_v=y) for x, y in widths
    }
    lewis: dict[str, Material] = {
        f"n = {n}": Lewis(emission=DARK, exponent=n) for n in (10, 20, 50, 100, 200)
    }
    profiles = ((2, 1, 50), (2, 1, 10), (2, 1, 200), (2, 0.5, 50), (2, -1, 50), (4, 1, 50))
    poulin: dict[str, Material] = {
        f"d = {d:g}, h = {h:g}, e = {e}": PoulinFournier(
            emission=DARK, distance=d, height=h, exponent=e
        )
        for d, h, e in profiles
    }
    every = {"ward": ward, "lewis": lewis, "poulin_fournier": poulin}
    return {
        name: {text: of_material(material) for text, material in each.items()}
        for name, each in every.items()
    }


def study(
    measured: Mapping[str, Source] | None = None,
    *,
    families: Mapping[str, Family] | None = None,
    bits: int = BITS,
    progress: Progress = silent,
) -> dict[str, Any]:
    """Errors of all codes as JSON.

    measured  further sources by name
    families  in place of the usual models
    bits      log2 of the samples along each angle
    """
    every = dict(models() if families is None else families)
    if measured:
        every["measured"] = measured
    todo = [(family, text, every[family][text]) for family in every for text in every[family]]
    found = []
    for number, (family, text, source) in enumerate(todo):
        progress("codes", number, len(todo))
        found.append({"family": family, "parameters": text, **_of_source(source, family, bits)})
    progress("codes", len(todo), len(todo))
    return finite(
        {
            **provenance(),
            "machine": this_machine().as_dict(),
            "samples": 16**bits,
            "sample_bytes": 12 * 16**bits,
            "floor": FLOOR,
            "ratios": RATIOS,
            "neural_bytes": NEURAL,
            "sources": found,
            "paper": PAPER,
        }
    )


class _Raw:
    """The samples of a source on the paper's grid, and errors at them."""

    def __init__(self, source: Source, bits: int) -> None:
        self.grid = Grid(layout.GENERAL, bits, bits, 1 << bits, 1 << bits)
        self.values = tabulate(source, self.grid, within=1)
        self._floor = floors(self.values, FLOOR)
        self._wi, self._wo = incident(self.grid).reshape(-1, 3), outgoing(self.grid).reshape(-1, 3)

    def errors(self, found: NDArray[np.float64]) -> Errors:
        return errors_of(found.reshape(self.values.shape), self.values, self.grid, self._floor)

    def errors_of_code(self, code: Encoded) -> Errors:
        return self.errors(values_of(code.data, self._wi, self._wo))


def _of_source(source: Source, family: str, bits: int) -> dict[str, Any]:
    raw, whole = _Raw(source, bits), 12 * 16**bits
    sizes = [whole // ratio for ratio in RATIOS]
    sizes += [size for size in (*SMALL, NEURAL) if size < sizes[-1]]
    codes = _papers(raw, sizes) + _same_grid(raw, sizes)
    codes += [one for finer in range(3) for one in _ours(source, raw, sizes, bits - finer)]
    own = grid_for(source, bits)
    return {
        "symmetry": layout.SYMMETRIES[own.symmetry],
        "mean_value": float(raw.values.mean(dtype=np.float64)),
        "codes": codes,
        "bytes_at_papers_error": [
            encode(tabulate(source, own, within=1), own, Target(error=error, floor=FLOOR)).bytes
            for error in PAPER.get(family, {}).get("mean", ())
        ],
    }


def _papers(raw: _Raw, sizes: Sequence[int]) -> list[dict[str, Any]]:
    papers, codes = PapersCode(raw.values, FLOOR), []
    for name, octets in ((FLOATS, False), (OCTETS, True)):
        for size in sizes:
            kept = papers.kept(size, octets)
            if kept > 0:
                errors = raw.errors(papers.at(kept, octets))
                own = papers.bytes_of(kept, octets)
                codes.append(_entry(name, size, own, errors, errors))
    return codes


def _same_grid(raw: _Raw, sizes: Sequence[int]) -> list[dict[str, Any]]:
    codes = []
    for size in sizes:
        code = _fitting(raw.values, raw.grid, size)
        if code is not None:
            errors = raw.errors_of_code(code)
            codes.append(_entry(SAME_GRID, size, code.bytes, errors, errors))
    return codes


def _ours(source: Source, raw: _Raw, sizes: Sequence[int], bits: int) -> list[dict[str, Any]]:
    """Codes of the grid of so many bits, each size once."""
    if bits < 2:
        return []
    grid = grid_for(source, bits)
    values = tabulate(source, grid, within=1)
    wi, wo = incident(grid).reshape(-1, 3), outgoing(grid).reshape(-1, 3)
    codes: list[dict[str, Any]] = []
    for size in sizes:
        code = _fitting(values, grid, size)
        if code is None:
            continue
        if codes and codes[-1]["bytes"] == code.bytes:
            codes.append({**codes[-1], "at_most": size})
            continue
        found = values_of(code.data, wi, wo).reshape(values.shape)
        own = errors_of(found, values, grid, floors(values, FLOOR))
        codes.append(_entry(OURS, size, code.bytes, own, raw.errors_of_code(code), 1 << bits))
    return codes


def _fitting(values: NDArray[np.floating], grid: Grid, size: int) -> Encoded | None:
    """The code of so many bytes; None where it has no smaller one."""
    try:
        return encode(values, grid, Target(bytes=size, floor=FLOOR))
    except InputError:
        return None


def _entry(
    scheme: str, at_most: int, size: int, own: Errors, at_papers: Errors, cells: int | None = None
) -> dict[str, Any]:
    """at_most bytes were allowed; errors at the code's own samples, and at the paper's."""
    return {
        "scheme": scheme,
        "cells": cells,
        "at_most": at_most,
        "bytes": size,
        "own": own.as_dict(),
        "at_papers": at_papers.as_dict(),
    }
