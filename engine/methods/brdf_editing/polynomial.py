"""Light on the gather cloud as a polynomial in the albedo that is in hand.

`brdf_editing` (Ben-Artzi et al. 2008), eq. 27, 28: with all BRDFs frozen but one, what a matt
bounce gives is linear in that one's albedo, and B bounces are a polynomial of degree B. The paper
sums up the elements of its tensor; here the light is passed on from gather sample to gather sample,
power by power, so that no factor is ever divided out and the number of objects does not matter:

    R_0 = e,    R_{b+1} = e + a (I + G R_b) / π

with the emission e, the albedo a, the irradiance I from the scene's lights, and that which radiance
R brings in one bounce, G R.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.product import multiply
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.tiles import run_tiles
from engine.numerics import haar

Light = NDArray[np.float32]


class Sent(NamedTuple):
    """What the cloud sends in all: radiance times area, by powers of the albedo x in hand.

    total  (bounces + 1, 3)   after the last bounce
    last   (bounces + 1, 3)   of it what that bounce brought; before the first, the light that fell
    kept   (2, 3)             what a bounce keeps of light, p + q x
    """

    total: NDArray[np.float64]
    last: NDArray[np.float64]
    kept: NDArray[np.float64]


class Later(NamedTuple):
    """Light on the cloud by powers of the albedo in hand, (n_g, bounces + 1, 3) each.

    radiance    of samples, after all bounces
    incoming    radiance of samples, after one bounce less
    irradiance  over π, that it makes of `incoming` and the lights
    """

    radiance: Light
    incoming: Light
    irradiance: Light


class CloudLight:
    """Passes light on within the cloud."""

    def __init__(self, cloud: GatherCloud, rows: PackedRows) -> None:
        """Rows of one bounce, those of `run_tiles`."""
        self._cloud, self._rows = cloud, rows
        self._runs = run_tiles(len(cloud))
        # As transport is reciprocal, all that arrives is what each sends times how closed it lies.
        even = haar.forward(np.ones((len(cloud), 3), np.float32))
        self._closed = self._arriving(even)[:, 0].astype(np.float64) * cloud.area

    def arriving(self, radiance: Light) -> Light:
        """(n_g, 3): irradiance by radiance (n_g, 3) of the cloud, without culling's loss."""
        found = self._arriving(haar.forward(radiance))
        due = float((self._closed @ radiance.astype(np.float64)).sum())
        came = float((self._cloud.area.astype(np.float64) @ found).sum())
        return found * np.float32(due / came if came > 0 else 1.0)

    def _arriving(self, wavelets: Light) -> Light:
        return multiply(*self._rows, wavelets, self._runs, len(wavelets))

    def powers(self, first: Light, fixed: Light, edited: Light, bounces: int) -> tuple[Later, Sent]:
        """Light by powers of the albedo x in hand.

        first (n_g, 3) is I, the albedo `fixed` + x · `edited`, (n_g, 3) each.
        """
        powers, onto, before = np.zeros((3, bounces + 1, len(first), 3), np.float32)
        powers[0] = self._cloud.emission
        last = np.zeros((bounces + 1, 3))
        last[0] = self._sent(first) / -np.pi
        for bounce in range(bounces):
            before, onto = powers.copy(), np.zeros_like(powers)
            if bounce == bounces - 1:
                last = self._sent(powers)
            onto[0] = first
            for n in range(bounce + 1):
                if bounce or powers[n].any():
                    onto[n] += self.arriving(powers[n])
            onto /= np.float32(np.pi)
            powers[:] = onto * fixed
            powers[1:] += onto[:-1] * edited
            powers[0] += self._cloud.emission
        total, closed = self._sent(powers), self._closed / (np.pi * self._cloud.area.sum())
        kept = np.stack([closed @ fixed, closed @ edited])
        later = Later(*(np.ascontiguousarray(a.swapaxes(0, 1)) for a in (powers, before, onto)))
        return later, Sent(total, total - last, kept)

    def _sent(self, radiance: Light) -> NDArray[np.float64]:
        """(..., 3): radiance (..., n_g, 3) times the area of samples, summed up."""
        return np.asarray(self._cloud.area @ radiance, np.float64)
