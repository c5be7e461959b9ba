"""Spectral reflectance to linear sRGB, as the CIE 1931 observer of 2 degrees sees it under D65.

D65 is the white of sRGB. Under it a perfect white diffuser is (1, 1, 1) without an adaptation of
colours on top; under an equal-energy illuminant it would come out pink, and an adaptation would
have to turn it back. The whole is linear in the reflectance: one matrix (3, wavelengths).

Between wavelengths the reflectance is linear, beyond the first and last it stays as it is there
(CIE 15:2018 §7.2.2.2 allows both). So the integrals run over the tables of 360 to 830 nm in steps
of 1 nm, whatever the instrument's range and steps are. The rows are scaled to a sum of 1, which
they have but for the digits to which the matrix of IEC 61966-2-1 is rounded.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

FIRST_NM, LAST_NM = 360, 830
OBSERVER = "CIE 1931 2 Degree Standard Observer"


def linear_srgb(
    wavelengths: NDArray[np.float64], reflectance: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Colours (n, 3) of spectra (n, k), for k ascending wavelengths in nm.

    Linear, Rec. 709 primaries; a constant spectrum gives three times its value. Channels are
    negative where the colour is more saturated than any that sRGB can mix.
    """
    return reflectance @ _weights(tuple(wavelengths.tolist())).T


@lru_cache(8)
def _weights(wavelengths: tuple[float, ...]) -> NDArray[np.float64]:
    """Matrix (3, k) from reflectances at wavelengths to linear sRGB."""
    # It takes a second to load, which only those who read spectra should wait for.
    import colour

    shape = colour.SpectralShape(FIRST_NM, LAST_NM, 1)
    observer = colour.MSDS_CMFS[OBSERVER].copy().align(shape).values
    light = colour.SDS_ILLUMINANTS["D65"].copy().align(shape).values
    unit = np.eye(len(wavelengths))
    between = np.stack([np.interp(shape.wavelengths, wavelengths, hat) for hat in unit], axis=1)
    xyz = observer.T @ (light[:, None] * between)
    rgb = colour.RGB_COLOURSPACES["sRGB"].matrix_XYZ_to_RGB @ xyz
    return np.asarray(rgb / rgb.sum(axis=1, keepdims=True), np.float64)
