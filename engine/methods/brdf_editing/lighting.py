"""The lights of a sitting: what each sends to pixels and to the gather cloud, found when it moves.

Past the paper, which holds the light fixed: what rays meet does not depend on it, so that a moved
light is its shadow rays, and another folding of the material in hand. Matt surfaces take the direct
light of `fixed_view.direct`; which points of a light are seen is asked for glossy ones alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.shading import HIDDEN, VISIBLE
from engine.brdf.base import DIFFUSE
from engine.brdf.diffuse import Diffuse
from engine.brdf.table import INDEX
from engine.light.base import Light
from engine.light.table import light_table
from engine.methods.brdf_editing.light_seen import MOST, Shining, seen_of, shining
from engine.methods.brdf_editing.places import Places
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.direct import (
    light_on_centres,
    light_on_pixels,
    light_on_points,
    light_on_subsamples,
    seen_nearby,
)
from engine.methods.fixed_view.frame_buffer import Points
from engine.methods.fixed_view.view import View
from engine.numerics.parallel import for_ranges
from engine.scene.rays import RayTracer

QUICK = 16  # points of a light while the hand moves
PIXELS = 4096  # of a piece of work


class Lit(NamedTuple):
    """Pixels, sub-samples and the gather cloud under some lights.

    lights  those that shine
    seen    (n + 4 m, l) uint64     which of their points glossy ones see, see `light_seen`
    direct  (n + 4 m, 3) float32    irradiance over π
    first   (n_g, 3) float32        irradiance of gather samples, by lights alone
    second  (n_g, l) uint64         which points gather samples see; (n_g, 0) where nobody asks
    """

    lights: Shining
    seen: NDArray[np.uint64]
    direct: NDArray[np.float32]
    first: NDArray[np.float32]
    second: NDArray[np.uint64]


@dataclass(frozen=True)
class _One:
    """The same of one light; asked (n + 4 m,) bool tells where `seen` is known."""

    lit: Lit
    asked: NDArray[np.bool_]


class Lighting:
    """Knows the lights of the last frame."""

    def __init__(
        self,
        view: View,
        places: Places,
        cloud: GatherCloud,
        asks_second: bool,
    ) -> None:
        """The view, and whether somebody asks what the cloud sees of lights."""
        self._view, self._cloud, self._places = view, cloud, places
        self._asks_second = asks_second
        self._white_cloud = _white(cloud.points)
        buffer = view.buffer
        self._white = replace(buffer, centre=_white(buffer.centre), sub=_white(buffer.sub))
        self._count = len(buffer.centre) + len(buffer.sub)
        self._white_coarse = _white(view.points(2))
        self._known: dict[tuple[Light, int], _One] = {}

    def of(self, lights: Sequence[Light], scale: int, glossy: NDArray[np.bool_]) -> Lit:
        """All under lights, with what glossy points (n + 4 m,) see of them.

        At scale 2 only every second pixel of every second row is right.
        """
        on = [light for light in lights if light.enabled]
        known = {}
        for light in on:
            # What was found for whole pictures serves small ones too.
            kind = 1 if (light, 1) in self._known else scale
            one = self._known.get((light, kind)) or self._look(light, scale)
            self._ask(light, scale, one, glossy)
            known[light, kind] = one
        self._known = known  # of lights that have moved on nothing is kept
        return self._together(on, [one.lit for one in known.values()])

    def _look(self, light: Light, scale: int) -> _One:
        rays, points, samples = self._view.scene.rays, self._count, len(self._cloud)
        on = shining([light], MOST if scale == 1 else QUICK)
        first = light_on_points(rays, self._white_cloud, light) * np.float32(np.pi)
        second = np.zeros((samples, 0), np.uint64)
        if self._asks_second:
            second = _seen(rays, self._cloud.points, on)
        seen, asked = np.zeros((points, 1), np.uint64), np.zeros(points, np.bool_)
        return _One(Lit(on, seen, self._direct(light, scale), first, second), asked)

    def _direct(self, light: Light, scale: int) -> NDArray[np.float32]:
        rays, buffer, view = self._view.scene.rays, self._white, self._view
        sub = light_on_subsamples(rays, buffer, light)
        if scale == 1:
            return np.concatenate([light_on_centres(rays, buffer, light), sub])
        out = np.zeros((self._count, 3), np.float32)
        out[self._places.pixels(scale)] = light_on_pixels(
            rays, self._white_coarse, view.coarse_alike, view.shape(scale)[1], light
        )
        out[len(buffer.centre) :] = sub
        return out

    def _ask(self, light: Light, scale: int, one: _One, glossy: NDArray[np.bool_]) -> None:
        """Find what points see that are glossy by now."""
        missing = glossy & ~one.asked
        if not missing.any():
            return
        rays, buffer, seen, on = self._view.scene.rays, self._white, one.lit.seen, one.lit.lights
        count, where = len(buffer.centre), self._places.pixels(scale)
        where = asked = where[missing[where]]
        if on.points[0] == MOST:
            # One ray from each tells where nothing is hidden, or all.
            width = buffer.camera.width
            _, near = seen_nearby(rays, buffer.centre, width, light_table([light]))
            seen[where[near[where] == VISIBLE]] = np.uint64(2 ** int(on.points[0]) - 1)
            where = where[near[where] == HIDDEN | VISIBLE]
        seen[where] = _seen(rays, buffer.centre.take(where), on)
        sub = np.flatnonzero(missing[count:])
        seen[count + sub] = _seen(rays, buffer.sub.take(sub), on)
        one.asked[asked] = one.asked[count + sub] = True

    def _together(self, on: Sequence[Light], found: Sequence[Lit]) -> Lit:
        points, samples = self._count, len(self._cloud)
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


def _white(points: Points) -> Points:
    """The same points, matt and white."""
    row = np.zeros_like(points.row)
    row[:, DIFFUSE : DIFFUSE + 3] = 1
    model = np.where(points.model >= 0, INDEX[Diffuse], -1).astype(np.int32)
    return replace(points, row=row, model=model)
