"""Samples, files and directions for the tests of measured materials."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from brdf.materials import hemisphere
from numpy.typing import NDArray

from engine.brdf import Material
from engine.brdf.acquisition import of_material
from engine.brdf.acquisition.completion import Completed, complete
from engine.brdf.acquisition.isotropy import is_isotropic
from engine.brdf.acquisition.samples import Samples


def pairs(n: int, seed: int = 1) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Pairs (n, 3), (n, 3), both uniform over the upper hemisphere."""
    rng = np.random.default_rng(seed)
    return hemisphere(rng, n), hemisphere(rng, n)


def turned(w: NDArray[np.float64], angle: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """Directions (n, 3) rotated about the normal by angles () or (n,) in radians."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([c * w[:, 0] - s * w[:, 1], s * w[:, 0] + c * w[:, 1], w[:, 2]], axis=1)


def sampled(
    material: Material, wi: NDArray[np.float64], wo: NDArray[np.float64], noise: float = 0.0
) -> Samples:
    """Samples of a model with so much relative noise."""
    rgb = of_material(material).evaluate(wi, wo)
    rng = np.random.default_rng(7)
    rgb = rgb * (1 + noise * rng.standard_normal((len(rgb), 1)))
    return Samples("sample", wi, wo, np.maximum(rgb, 0.0))


def completed(samples: Samples) -> Completed:
    return complete(samples, is_isotropic(samples))


def relative(a: NDArray[np.float64], b: NDArray[np.float64]) -> NDArray[np.float64]:
    """Relative errors (n,) of colours a (n, 3) against b."""
    return np.abs(a - b).sum(axis=1) / b.sum(axis=1)


def goniometer_file(
    path: Path,
    rows: Sequence[Sequence[float]],
    wavelengths: Sequence[float] = (450.0, 550.0, 650.0),
    count: str | None = None,
) -> Path:
    """Write a file as a goniometer does; `count` in place of the number of wavelengths."""
    lines = ["# a paint", "", "# num wls", str(len(wavelengths)) if count is None else count]
    lines += [" ".join(f"{w:g}" for w in wavelengths[:2])]
    lines += [" ".join(f"{w:g}" for w in wavelengths[2:]), "", "# theta i, phi i, theta s, phi s"]
    lines += [" ".join(f"{value:.6f}" for value in row) for row in rows]
    path.write_text("\n".join(lines) + "\n")
    return path
