"""What a code makes of highlights that are narrower than its cells.

An error over the samples of a grid tells nothing of what lies between them. So here source and code
are compared about the mirror image of the light, in steps far finer than any cell.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np

from engine.brdf import measured
from engine.brdf.acquisition.samples import directions
from engine.brdf.acquisition.survey import about_mirror
from engine.brdf.arrays import evaluate
from engine.brdf.base import ROW, SPECULAR
from engine.brdf.table import INDEX
from engine.brdf.wavelet.encoding import Encoded
from engine.brdf.wavelet.tabulate import Source

ANGLES_DEGREES = (0.0, 40.0, 70.0)  # of the light
AZIMUTHS_DEGREES = (10.0, 55.0, 100.0)  # the same, of a source that is not isotropic


@dataclass(frozen=True)
class Sharpness:
    """The worst of some directions of the light.

    peak       what the code has of the highest value
    light      what it reflects, as a part of what the source does
    misplaced  part of that which it reflects elsewhere, or does not
    """

    peak: float
    light: float
    misplaced: float


def sharpness_of(source: Source, code: Encoded) -> Sharpness:
    """Compare a code with what it was made from, at a few thousand pairs of directions."""
    row = np.zeros(ROW, np.float32)
    row[SPECULAR : SPECULAR + 3] = 1.0
    measured.fill(row, code)
    found = []
    azimuths = AZIMUTHS_DEGREES[:1] if source.isotropic else AZIMUTHS_DEGREES
    for angle, azimuth in product(ANGLES_DEGREES, azimuths):
        wi = directions(np.radians([angle]), np.radians([azimuth]))
        wo, solid = about_mirror(wi[0])
        wi = np.repeat(wi, len(wo), axis=0)
        true = source.evaluate(wi, wo).mean(axis=1)
        shown = evaluate(INDEX[measured.Measured], row, wi, wo).mean(axis=1)
        weight = solid * wo[:, 2]
        whole = float(weight @ true)
        if whole > 0.0:
            light, off = float(weight @ shown), float(weight @ np.abs(shown - true))
            found.append((float(shown.max() / true.max()), light / whole, 0.5 * off / whole))
    if not found:
        return Sharpness(1.0, 1.0, 0.0)
    peak, light, misplaced = np.array(found).T
    worst = int(np.argmax(np.abs(light - 1.0)))
    return Sharpness(float(peak.min()), float(light[worst]), float(misplaced.max()))
