"""The lights of a sitting: what each sends to pixels and to the gather cloud, found when it moves.

Past the paper, which holds the light fixed: what rays meet does not depend on it, so that a moved
light is its shadow rays, and another folding of the material in hand.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.light.base import Light
from engine.methods.brdf_editing.light_seen import MOST, Shining, seen_of, shining
from engine.methods.brdf_editing.places import Places
from engine.methods.brdf_editing.reflect import direct_of
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.direct import light_on_points
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.view import View
from engine.numerics.parallel import for_ranges
from engine.scene.rays import RayTracer

QUICK = 16  # points of a light while the hand moves
PIXELS = 4096  # of a piece of work


class Lit(NamedTuple):
    """Pixels, sub-samples and the gather cloud under some lights.

    lights  those that shine
    seen    (n + 4 m, l) uint64     which of their points each sees, see `light_seen`
    direct  (n + 4 m, 3) float32    irradiance over π
    first   (n_g, 3) float32        irradiance of gather samples, by lights alone
    second  (n_g, l) uint64         which points gather samples see; (n_g, 0) where nobody asks
    """

    lights: Shining
    seen: NDArray[np.uint64]
    direct: NDArray[np.float32]
    first: NDArray[np.float32]
    second: NDArray[np.uint64]


class Lighting:
    """Knows the lights of the last frame."""

    def __init__(
        self,
        view: View,
        places: Places,
        cloud: GatherCloud,
        lights: Sequence[Light],
        seen: NDArray[np.uint64],
        second: NDArray[np.uint64] | None,
    ) -> None:
        """Lights of the scene, and which of their points are seen, (n + 4 m, l) and (n_g, l)."""
        self._view, self._cloud, self._places = view, cloud, places
        self._surface = places.surface(view.scene.material_table)
        self._asks_second = second is not None
        row = cloud.points.row.copy()
        row[:, :3] = 1
        self._white = replace(cloud.points, row=row)
        self._known: dict[tuple[Light, int], Lit] = {}
        for q, light in enumerate(light for light in lights if light.enabled):
            behind = second[:, q : q + 1] if second is not None else None
            self._known[light, 1] = self._of_one(
                light, shining([light]), seen[:, q : q + 1], behind
            )

    def of(self, lights: Sequence[Light], scale: int) -> Lit:
        """All under lights; at scale 2 only every second pixel of every second row is right."""
        on = [light for light in lights if light.enabled]
        known = {}
        for light in on:
            # What was found for whole pictures serves small ones too.
            for kind in (1, scale):
                if (light, kind) in self._known:
                    known[light, kind] = self._known[light, kind]
                    break
            else:
                known[light, scale] = self._look(light, scale)
        self._known = known  # of lights that have moved on nothing is kept
        return self._together(on, list(known.values()))

    def _look(self, light: Light, scale: int) -> Lit:
        buffer, rays = self._view.buffer, self._view.scene.rays
        on = shining([light], MOST if scale == 1 else QUICK)
        seen = np.zeros((len(self._surface.model), 1), np.uint64)
        count, where = len(buffer.centre), self._places.pixels(scale)
        seen[where] = _seen(rays, buffer.centre.take(where), on)
        # Sub-samples of every edge: there are few.
        seen[count:] = _seen(rays, buffer.sub, on)
        behind = _seen(rays, self._cloud.points, on) if self._asks_second else None
        return self._of_one(light, on, seen, behind)

    def _of_one(
        self,
        light: Light,
        on: Shining,
        seen: NDArray[np.uint64],
        second: NDArray[np.uint64] | None,
    ) -> Lit:
        first = light_on_points(self._view.scene.rays, self._white, light) * np.float32(np.pi)
        if second is None:
            second = np.zeros((len(self._cloud), 0), np.uint64)
        return Lit(on, seen, direct_of(self._surface, on, seen), first, second)

    def _together(self, on: Sequence[Light], found: Sequence[Lit]) -> Lit:
        points, samples = len(self._surface.model), len(self._cloud)
        # Images of lights lie one behind the other in the table of all.
        whole = shining(on)
        counts = [lit.lights.points for lit in found]
        places = [lit.lights.place for lit in found]
        return Lit(
            whole._replace(
                points=np.concatenate([whole.points[:0], *counts]),
                place=np.concatenate([whole.place[:0], *places]),
            ),
            np.hstack([np.zeros((points, 0), np.uint64), *(lit.seen for lit in found)]),
            sum((lit.direct for lit in found), np.zeros((points, 3), np.float32)),
            sum((lit.first for lit in found), np.zeros((samples, 3), np.float32)),
            np.hstack([np.zeros((samples, 0), np.uint64), *(lit.second for lit in found)]),
        )


def _seen(rays: RayTracer, points: Points, on: Shining) -> NDArray[np.uint64]:
    """(n, 1) of one light."""
    out = np.zeros((len(points), 1), np.uint64)

    def piece(start: int, stop: int) -> None:
        out[start:stop] = seen_of(rays, points, on, start, stop)

    for_ranges(piece, len(points), grain=PIXELS)
    return out
