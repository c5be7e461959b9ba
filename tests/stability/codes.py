"""Codes of sources, as rows that the BRDF's calls take: what tests of measured materials share."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from brdf.acquisition.acquired import completed, pairs, sampled
from brdf.wavelet.sources import Formula, hemisphere
from numpy.typing import NDArray

from engine.brdf import albedo, evaluate
from engine.brdf import measured as code
from engine.brdf.acquisition.completion import Completed
from engine.brdf.acquisition.csv_table import COLUMNS
from engine.brdf.acquisition.samples import Samples
from engine.brdf.base import ROW, SPECULAR
from engine.brdf.built_in import BUILT_IN
from engine.brdf.measured import Measured
from engine.brdf.table import INDEX
from engine.brdf.wavelet.encoding import DEFAULT, Target
from engine.brdf.wavelet.tabulate import Source

Array = NDArray[np.float64]
MODEL = INDEX[Measured]


def row_of(source: Source, bits: int = 4, target: Target = DEFAULT) -> NDArray[np.float32]:
    """The row of a code of 2^bits cells, white."""
    row = np.zeros(ROW, np.float32)
    row[SPECULAR : SPECULAR + 3] = 1
    code.fill(row, code.encoded(source, bits, target))
    return row


def values(row: NDArray[np.float32], wi: Array, wo: Array) -> Array:
    return evaluate(MODEL, row, wi, wo)


def reflected(row: NDArray[np.float32], angle_degrees: float) -> float:
    """Directional albedo of the first channel, seen from so far off the normal."""
    theta = np.radians(angle_degrees)
    return float(albedo(MODEL, row, [np.sin(theta), 0, np.cos(theta)])[0, 0])


def by_cosine(seed: int = 1, n: int = 3000) -> tuple[Array, Array]:
    """Pairs of directions, each with cosine density."""
    rng = np.random.default_rng(seed)
    return hemisphere(rng, n), hemisphere(rng, n)


def off(found: Array, true: Array) -> tuple[float, float]:
    """(relative L2 error, median relative error)."""
    apart = np.abs(found - true)
    relative = apart.sum(axis=1) / true.sum(axis=1)
    return float(np.linalg.norm(apart) / np.linalg.norm(true)), float(np.median(relative))


def glint(base: float, peak: float) -> Formula:
    """A highlight of the half vector over an even base."""
    return Formula(
        lambda wi, wo: (
            base
            + peak * np.exp(-30 * np.sum((wi + wo)[..., :2] ** 2, axis=-1))[..., None] * np.ones(3)
        ),
        True,
    )


def plastic_samples(n: int, noise: float = 0.0) -> Samples:
    """The built-in plastic at random pairs, with relative noise."""
    return sampled(BUILT_IN["plastic"], *pairs(n), noise)


def complete_of(value: Array, n: int) -> Completed:
    """Completed samples of colours (n, 3) at `pairs(n)`."""
    return completed(Samples("odd", *pairs(n), value))


def write_table(path: Path, *rows: str) -> Path:
    path.write_text("\n".join([",".join(COLUMNS), *rows]) + "\n")
    return path
