"""Bounces within the gather cloud: the matrix M of the paper, applied one bounce at a time."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.product import multiply
from engine.diagnosis import Diagnosis
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.importance import trial_lights
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.tiles import run_tiles
from engine.numerics import haar
from engine.scene.scene import Scene

TRIALS, TAIL_BOUNCES = 25, 16
NEGLIGIBLE = 0.02  # of all light: what the bounces may miss before the user is told
MOST_DECAY = 0.99  # a room that keeps more than this of its light per bounce is not believed


class Fading(NamedTuple):
    """How light of one kind goes on from bounce to bounce.

    gains  of every bounce: they give back what culling loses of the light that arrives
    tail   (3,) the sum of all bounces after the last that is computed, by that one
    fades  (3,) what that last one keeps of the one before
    """

    gains: list[float]
    tail: NDArray[np.float64]
    fades: NDArray[np.float64]


class Bounced(NamedTuple):
    """Light and all its bounces.

    total   (n_g, 3) float32  in wavelets
    unsure  float             how much of the power may be wrong, as its tail is a guess
    power   float             of all bounces that are computed
    first   float             of the light before its first bounce
    whole   float             of all, with what is guessed
    """

    total: NDArray[np.float32]
    unsure: float
    power: float
    first: float
    whole: float

    @property
    def later(self) -> float:
        """Part of the light that has bounced."""
        return 1 - self.first / max(self.whole, 1e-30)


class Bounces:
    """I + P + ... + P^b and a guess of the rest, P = (albedo / π) G one bounce in wavelet space.

    P is applied b times at run time, which costs a few milliseconds, in place of the paper's matrix
    M of all bounces in colour. The bounces after those are guessed from the last one.
    """

    def __init__(
        self, scene: Scene, cloud: GatherCloud, rows: PackedRows, bounces: int, seed: int
    ) -> None:
        """Rows are those of `run_tiles`; lights at random places tell how light fades."""
        self._rows, self.count = rows, bounces
        self._runs = run_tiles(len(cloud))
        self.reflected = cloud.albedo / np.float32(np.pi)
        self._area = cloud.area.astype(np.float64)
        self._area_in_wavelets = haar.forward(self._area[:, None].astype(np.float32))[:, 0]
        even = haar.forward(np.ones((len(cloud), 3), np.float32))
        closed = self._arriving(even) * cloud.area[:, None]
        self._closed = haar.forward(closed)[:, 0].astype(np.float64)
        trials = trial_lights(scene, cloud, seed)[:TRIALS]
        self.of_lights = self.fading(
            [light_on_points(scene.rays, cloud.points, light) for light in trials]
        )

    def __call__(self, g: NDArray[np.float32], fading: Fading) -> Bounced:
        """All bounces of g (n_g, 3), in wavelets as the result is.

        The last bounce that is computed stands for those that follow: by then they are alike but
        for a factor, which light of the same kind has told.
        """
        total, b = g.copy(), g
        powers = [_power(g)]
        for gain in fading.gains:
            b = self._one_bounce(b, gain)
            total += b
            powers.append(_power(b))
        if self.count:
            total += b * fading.tail.astype(np.float32)
        return Bounced(total, *self.weighed(powers, fading))

    def weighed(
        self, powers: list[NDArray[np.float64]], fading: Fading
    ) -> tuple[float, float, float, float]:
        """(unsure, power, first, whole) as `Bounced` has them; `powers` (3,) of g and every bounce.

        A power is coefficient 0 of a light in wavelets, of each channel.
        """
        after, before = powers[-1], powers[max(0, len(powers) - 2)]
        power, first = float(np.sum(powers)), float(powers[0].sum())
        tail = float((after * fading.tail).sum())
        if self.count == 0:
            # The tail is left out, and so a part of all that there should be.
            return tail, power + tail, first, power + tail
        # Light that fades faster or slower than others of its kind has another tail.
        fades = after / np.maximum(before, 1e-30)
        off = np.abs(after * fading.tail * (fades / np.maximum(fading.fades, 1e-30) - 1))
        return float(off.sum()), power, first, power + tail

    def truncated(self, missing: float) -> Diagnosis | None:
        """What to say of the part of all light that may be missing, or too much."""
        if missing <= NEGLIGIBLE:
            return None
        return Diagnosis(
            "bounces_truncated",
            f"The light after {self.count} bounces is a guess, and may be {100 * missing:.0f} % of "
            "all light off; set bounces higher.",
            missing,
        )

    def fading(self, lights: list[NDArray[np.float32]]) -> Fading:
        """That of the middle one of lights (n_g, 3): in a white cupboard one fades too slowly."""
        b = [haar.forward(light) for light in lights]
        gains, sums, fluxes = [], [[_power(x) for x in b]], [[self._flux(x) for x in b]]
        for _ in range(self.count + TAIL_BOUNCES):
            arriving = [self._arriving(light) for light in b]
            gains.append(self._gain(b, arriving))
            b = [self._reflect(light, gains[-1]) for light in arriving]
            sums.append([_power(light) for light in b])
            fluxes.append([self._flux(light) for light in b])
        power, flux = np.maximum(sums, 1e-30), np.maximum(fluxes, 1e-30)  # (bounces, lights, 3)
        decay = np.clip(flux[-1] / flux[-2], 0, MOST_DECAY)
        rest = flux[self.count + 1 :].sum(axis=0) + flux[-1] * decay / (1 - decay)
        fades = power[self.count] / power[max(0, self.count - 1)]
        return Fading(
            gains[: self.count],
            np.median(rest / flux[self.count], axis=0),
            np.median(fades, axis=0),
        )

    def _one_bounce(self, light: NDArray[np.float32], gain: float) -> NDArray[np.float32]:
        """gain P light, both (n_g, 3) float32 in wavelets: what the cloud reflects of its light."""
        return self._reflect(self._arriving(light), gain)

    def _arriving(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        return multiply(*self._rows, light, self._runs, len(light))

    def _reflect(self, arriving: NDArray[np.float32], gain: float) -> NDArray[np.float32]:
        return haar.forward(arriving * (np.float32(gain) * self.reflected))

    def _flux(self, light: NDArray[np.float32]) -> NDArray[np.float64]:
        """(3,): the sum of a light over the area that samples stand for, from its wavelets."""
        return self._area_in_wavelets.astype(np.float64) @ light

    def _gain(
        self, lights: list[NDArray[np.float32]], arriving: list[NDArray[np.float32]]
    ) -> float:
        """What gives back the light that culling loses in a bounce, for the middle one of lights.

        As transport is reciprocal, what should arrive in all, over all area, is what every sample
        sends, times the share of its own hemisphere that others fill.
        """
        due = [max(float((self._closed @ light).sum()), 1e-30) for light in lights]
        found = [max(float(self._area @ light.sum(axis=1)), 1e-30) for light in arriving]
        return float(np.median(np.divide(due, found)))


def _power(light: NDArray[np.float32]) -> NDArray[np.float64]:
    """(3,): the sum of a light on the cloud, but for a factor, from its wavelets (n_g, 3)."""
    return light[0].astype(np.float64)
