"""Bounces within the gather cloud: the matrix M of the paper, applied one bounce at a time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.product import multiply
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.importance import trial_lights
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.tiles import run_tiles
from engine.numerics import haar
from engine.scene.scene import Scene

TRIALS, TAIL_BOUNCES = 25, 16
MOST_DECAY = 0.99  # a room that keeps more than this of its light per bounce is not believed


class Bounces:
    """I + P + ... + P^b and a guess of the rest, P = (albedo / π) G one bounce in wavelet space.

    P is applied b times at run time, which costs a few milliseconds, in place of the paper's matrix
    M of all bounces in colour. The bounces after those are guessed from the last one.
    """

    def __init__(
        self, scene: Scene, cloud: GatherCloud, rows: PackedRows, bounces: int, seed: int
    ) -> None:
        """Rows are those of `run_tiles`; lights at random places tell gains and tail."""
        self._scene, self._cloud, self._rows, self.count = scene, cloud, rows, bounces
        self._runs = run_tiles(len(cloud))
        self.reflected = cloud.albedo / np.float32(np.pi)
        even = haar.forward(np.ones((len(cloud), 3), np.float32))
        self._area = cloud.area.astype(np.float64)
        closed = self._arriving(even) * cloud.area[:, None]
        self._closed = haar.forward(closed)[:, 0].astype(np.float64)
        gains, self.tail, self._fades = self._trial_bounces(seed)
        self.gains = gains[:bounces]

    def __call__(self, g: NDArray[np.float32]) -> tuple[NDArray[np.float32], float]:
        """Sum of all bounces in wavelets (n_g, 3), and how wrong its tail may be as a part of it.

        The last bounce that is computed stands for those that follow: by then they are alike but
        for a factor, which trial lights have told.
        """
        total, b = g.copy(), g
        powers = [_power(g)]
        for gain in self.gains:
            b = self._one_bounce(b, gain)
            total += b
            powers.append(_power(b))
        if self.count:
            total += b * self.tail.astype(np.float32)
        return total, self.missing(powers)

    def missing(self, powers: list[NDArray[np.float64]]) -> float:
        """How wrong the tail may be, as a part of all light; `powers` (3,) of g and every bounce.

        A power is coefficient 0 of a light in wavelets, of each channel.
        """
        after, before = powers[-1], powers[max(0, len(powers) - 2)]
        energy = max(float(np.sum(powers)), 1e-30)
        if self.count == 0:
            return float((after * self.tail).sum()) / energy
        # Light that fades faster or slower than the trial lights has another tail.
        fades = after / np.maximum(before, 1e-30)
        off = np.abs(after * self.tail * (fades / np.maximum(self._fades, 1e-30) - 1))
        return float(off.sum()) / energy

    def _one_bounce(self, light: NDArray[np.float32], gain: float) -> NDArray[np.float32]:
        """gain P light, both (n_g, 3) float32 in wavelets: what the cloud reflects of its light."""
        return self._reflect(self._arriving(light), gain)

    def _arriving(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        return multiply(*self._rows, light, self._runs, len(light))

    def _reflect(self, arriving: NDArray[np.float32], gain: float) -> NDArray[np.float32]:
        return haar.forward(arriving * (np.float32(gain) * self.reflected))

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

    def _trial_bounces(
        self, seed: int
    ) -> tuple[list[float], NDArray[np.float64], NDArray[np.float64]]:
        """(gains, tail, fades) of the light of trial lights, the middle ones of each.

        gains, one for every bounce, give back what culling loses of the light that arrives. tail
        (3,) is the sum of all bounces after the last that is computed, by that one; fades (3,) is
        what that one keeps of the one before.
        """
        cloud, bounces = self._cloud, self.count
        lights = [
            haar.forward(light_on_points(self._scene.rays, cloud.points, light))
            for light in trial_lights(self._scene, cloud, seed)[:TRIALS]
        ]
        gains, sums = [], [[_power(b) for b in lights]]
        for _ in range(bounces + TAIL_BOUNCES):
            arriving = [self._arriving(light) for light in lights]
            gains.append(self._gain(lights, arriving))
            lights = [self._reflect(light, gains[-1]) for light in arriving]
            sums.append([_power(b) for b in lights])
        power = np.maximum(sums, 1e-30)  # (bounces, lights, 3)
        decay = np.clip(power[-1] / power[-2], 0, MOST_DECAY)
        rest = power[bounces + 1 :].sum(axis=0) + power[-1] * decay / (1 - decay)
        fades = power[bounces] / power[max(0, bounces - 1)]
        # A light in a white cupboard fades far more slowly than most do: no mean, but the middle.
        return gains, np.median(rest / power[bounces], axis=0), np.median(fades, axis=0)


def _power(light: NDArray[np.float32]) -> NDArray[np.float64]:
    """(3,): the sum of a light on the cloud, but for a factor, from its wavelets (n_g, 3)."""
    return light[0].astype(np.float64)
