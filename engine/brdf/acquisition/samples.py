"""Measured pairs of directions, as every reader of scattered data hands them on."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.errors import InputError

ON_HORIZON = 1e-6  # a cosine this far below 0 is a rounded angle of 90 degrees


@dataclass(frozen=True, eq=False)
class Samples:
    """Scattered samples of one BRDF, and what had to be done to them.

    name          of the material
    wi, wo        (n, 3) float64, unit, local (z the normal), leaving the surface, z ≥ 0
    rgb           (n, 3) float64, BRDF in sr⁻¹ without the cosine, linear sRGB, ≥ 0
    dropped       rows left out because a direction lies below the surface
    clamped       measured values below 0, which became 0
    out_of_gamut  samples whose colour no sRGB display mixes: their negative channels became 0
    """

    name: str
    wi: NDArray[np.float64]
    wo: NDArray[np.float64]
    rgb: NDArray[np.float64]
    dropped: int = 0
    clamped: int = 0
    out_of_gamut: int = 0


def directions(theta: NDArray[np.float64], phi: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 3) unit directions at angles (n,) in radians from the normal and about it."""
    r = np.sin(theta)
    return np.stack([r * np.cos(phi), r * np.sin(phi), np.cos(theta)], axis=1)


def above(w: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which of directions (n, 3) do not lie below the surface."""
    return w[:, 2] >= -ON_HORIZON


def made(
    path: Path,
    wi: NDArray[np.float64],
    wo: NDArray[np.float64],
    rgb: NDArray[np.float64],
    *,
    clamped: int = 0,
    out_of_gamut: int = 0,
) -> Samples:
    """Samples of the rows whose directions leave the surface; the arguments hold all rows.

    Raises InputError, naming the file, where no row is left.
    """
    kept = above(wi) & above(wo)
    if not kept.any():
        raise InputError("no row has both of its directions above the surface", file=str(path))
    return Samples(
        path.stem,
        _raised(wi[kept]),
        _raised(wo[kept]),
        np.maximum(rgb[kept], 0.0),
        dropped=int((~kept).sum()),
        clamped=clamped,
        out_of_gamut=out_of_gamut,
    )


def _raised(w: NDArray[np.float64]) -> NDArray[np.float64]:
    """Directions (n, 3) with what rounding put below the horizon raised to it."""
    return np.concatenate([w[:, :2], np.maximum(w[:, 2:], 0.0)], axis=1)
