"""What an environment sends to gather and view samples, by rows like those of the gather cloud.

With e the radiances of the environment samples and E the rows of rays that leave the scene,

    g  = direct + albedo / π · E_bounce e        light of the environment on gather samples
    v += k_d * (E_d e) + k_g * (E_g e)           on view samples, direct (§6 of Hašan et al. 2006)

Suns in a map are too small for that: they shine as lights do (`engine.light.lamps`).
"""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.product import multiply
from engine.diagnosis import Diagnosis
from engine.light.environment import Environment, is_same
from engine.light.environment_samples import DEPTH, averaged, environment_samples
from engine.light.lamps import Lamp, split, suns
from engine.light.sun import SunLight
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.tiles import run_tiles
from engine.numerics import haar

Picture = NDArray[np.float32]

TINY = 1000  # a lamp in a map fills so small a part of the sphere, or less
# How far light from such lamps is off, times the root of the rays of a point: 3 on an open floor,
# where neighbours help each other, and 6 in a court.
LAMPS_OFF = 4.0
SHARP = 0.05  # error of the rows from which on the user is told

NONE = np.zeros((0, 3), np.float32)


class EnvironmentRows(NamedTuple):
    """E_bounce, E_d and E_g."""

    bounce: PackedRows
    final: PackedRows
    gloss: PackedRows


class EnvironmentLight:
    """The light of one environment after the other; that of the last one is kept."""

    def __init__(
        self, cloud: GatherCloud, rows: EnvironmentRows, tiles: dict[int, NDArray[np.int32]]
    ) -> None:
        """Tiles of final and gloss rows by scale."""
        self._rows, self._tiles = rows, tiles
        self._sees_out = any(len(part.ids) for part in rows)
        self._runs = run_tiles(len(cloud))
        self._reflected = cloud.albedo / np.float32(np.pi)
        self._environment: Environment | None = None
        self._samples = self.radiance = NONE
        self._map, self._rest, self._lamps = NONE, NONE, list[Lamp]()
        self.suns: tuple[SunLight, ...] = ()
        self.sharpness = 0.0
        self._gather: Picture | None = None
        self._view: dict[int, tuple[Picture, Picture]] = {}

    def use(self, environment: Environment) -> None:
        """The environment of the calls that follow."""
        if is_same(self._environment, environment):
            return
        self._environment = environment
        # Only a map that was not seen before is searched for lamps.
        if self._map is not environment.radiance:
            self._map = environment.radiance
            self._rest, self._lamps = split(averaged(environment.radiance))
        self.suns = suns(environment, self._lamps) if self._sees_out else ()
        samples = environment_samples(replace(environment, radiance=self._rest))
        self.sharpness = brightest_share(samples)
        self.radiance = samples
        self._samples = haar.forward(samples)
        self._gather, self._view = None, {}

    @property
    def gather(self) -> Picture:
        """(n_g, 3): what gather samples reflect of it."""
        if self._gather is None:
            self._gather = self._reflect(self._samples)
        return self._gather

    @property
    def white(self) -> Picture:
        """(n_g, 3): what they would reflect of radiance 1 from everywhere."""
        return self._reflect(haar.forward(np.ones((4**DEPTH, 3), np.float32)))

    def _reflect(self, samples: Picture) -> Picture:
        arriving = multiply(*self._rows.bounce, samples, self._runs, len(self._reflected))
        return self._reflected * np.maximum(arriving, 0)

    def view(self, scale: int, n: int) -> tuple[Picture, Picture]:
        """(n, 3) each: what arrives at the matt and at the glossy part of n view samples."""
        if scale not in self._view:
            final, gloss = (
                multiply(*rows, self._samples, self._tiles[scale], n)
                for rows in (self._rows.final, self._rows.gloss)
            )
            self._view[scale] = final, gloss
        return self._view[scale]

    def warnings(self, rays: int) -> list[Diagnosis]:
        """What rows of so many rays cannot hold of the environment in use."""
        size = self.sharpness * LAMPS_OFF / float(np.sqrt(rays))
        if size < SHARP or not self._sees_out:
            return []
        return [
            Diagnosis(
                "environment_too_sharp",
                f"{100 * self.sharpness:.0f} % of the environment's light come from a thousandth "
                "of the sphere. That is too small for the rays of the precompute: its shadows are "
                f"blurred, and the light may be {100 * size:.0f} % off. Take it out of the map and "
                "put a light of type sun in its place.",
                size,
            )
        ]


def brightest_share(samples: NDArray[np.float32]) -> float:
    """Part of the light of environment samples (n_e, 3) that the brightest of them hold."""
    bright = samples.mean(axis=1, dtype=np.float64)
    count = len(bright) // TINY
    total = bright.sum()
    return float(np.partition(bright, -count)[-count:].sum() / total) if total > 0 else 0.0
