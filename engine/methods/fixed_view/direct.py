"""Direct light on the deep frame-buffer and on the gather cloud, one light at a time.

Light is additive, so every light has a picture of its own. The pictures of lights that did not
change are kept (§5 of Hašan et al. 2006 caches all lights but the moving one).
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Iterator
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.penumbra import smooth_penumbrae
from engine.backend.cpu.shading import (
    HIDDEN,
    VISIBLE,
    average,
    light_edges,
    light_points,
    on_tangent_planes,
    seen_around,
)
from engine.light.base import Light
from engine.light.table import light_table
from engine.methods.fixed_view.frame_buffer import FINE, FrameBuffer, Points
from engine.scene.rays import RayTracer

# A light with extent shines from an 8 x 8 grid of its points. No point of a surface asks all of
# them: neighbours ask different ones, and in a picture they are averaged afterwards.
PER_PIXEL, PER_SUBSAMPLE, PER_PENUMBRA_PIXEL, PER_COARSE_PENUMBRA_PIXEL = 2, 4, 16, 4
CENTRE = np.full((1, 1, 2), 0.5)  # of a light without extent
BLOCK = 4  # pixels that share a pattern of `light_samples`
# Pixels each way in which somebody looks at every one of PROBES.
PROBE_REACH = 2


def probes() -> NDArray[np.float64]:
    """(16, 1, 2): from which point of a light a pixel looks for what hides it, by its phase.

    An even grid that goes up to the rim: the last of a light to go, and the first to come, is its
    end. Every block of 2 x 2 pixels holds a corner, two points of sides, and one within.
    """
    phase = np.arange(16)
    place = np.stack([phase & 1, phase >> 1 & 1]), np.stack([phase >> 2 & 1, phase >> 3 & 1])
    return np.where(place[0] == 0, place[1], (1 + place[1]) / 3).T[:, None].astype(np.float64)


KEPT_BYTES = 256e6
KEPT_LAMPS = 24
FEW = 16  # lights of which none is remembered as a part of a sum alone


def light_samples(light: Light, per_point: int) -> NDArray[np.float64]:
    """(groups, k, 2) sample points of a light: one, or a grid in groups of `per_point`.

    The grid is in the order of Sobol's (0, 2)-sequence: of any four in a row one lies in each
    quarter of the light, of any sixteen one in each sixteenth, of any eight one in each row and
    column. The lowest digit of y is flipped in half of the rows, by which x and y of the first
    eight and sixteen are uncorrelated, so that those few average any quadratic almost exactly.
    """
    if not light.has_extent:
        return CENTRE
    bit = np.arange(64)[:, None] >> np.arange(6) & 1
    x = bit[:, :3] @ (4, 2, 1)
    a, b, c = bit.sum(axis=1), bit[:, 1::2].sum(axis=1), bit[:, 2] + bit[:, 3]
    y = 4 * (a % 2) + 2 * (b % 2) + (a + b + c + 1) % 2
    return ((np.stack([x, y], axis=1) + 0.5) / 8).reshape(-1, per_point, 2)


def light_on_points(rays: RayTracer, points: Points, light: Light) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 of one light, from one of its points for each of ours."""
    return _light(rays, points, light, light_samples(light, 1))[0]


def light_on_pixels(
    rays: RayTracer, points: Points, alike: NDArray[np.uint8], width: int, light: Light
) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 of one light on a picture so wide, not antialiased.

    alike (n,) is from `alike_neighbours`.
    """
    if light.has_extent:
        return _soft_light(rays, points, alike, width, light, PER_COARSE_PENUMBRA_PIXEL)
    return _light(rays, points, light, CENTRE)[0]


def light_on_buffer(rays: RayTracer, buffer: FrameBuffer, light: Light) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 per pixel, antialiased as if four times supersampled."""
    centre, width = buffer.centre, buffer.camera.width
    if light.has_extent:
        radiance = _soft_light(rays, centre, buffer.alike, width, light, PER_PENUMBRA_PIXEL)
    else:
        radiance, visible = _light(rays, centre, light, CENTRE)
        skip = np.zeros(len(centre), np.bool_)
        skip[buffer.edge] = True
        # Where light ends within a pixel, light its tangent plane at a finer grid of places.
        pixel = light_edges(visible, skip, width)
        places = on_tangent_planes(
            pixel, buffer.camera.position, centre.view, centre.position, centre.geometric, width,
            FINE,
        )  # fmt: skip
        fine, _ = _light(rays, centre, light, CENTRE, np.repeat(pixel, len(FINE)), places)
        average(pixel, fine, radiance)
    sub, _ = _light(rays, buffer.sub, light, light_samples(light, PER_SUBSAMPLE))
    average(buffer.edge, sub, radiance)
    return radiance


def _soft_light(
    rays: RayTracer,
    points: Points,
    alike: NDArray[np.uint8],
    width: int,
    light: Light,
    per_penumbra: int,
) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 of a light with extent on a picture so wide.

    One ray in every pixel tells where all of the light is seen, none of it, or some: there are
    `per_penumbra` of them, and in full light none more.
    """
    _, visible = _light(rays, points, light, probes())
    near = seen_around(visible, width, PROBE_REACH)
    out = np.zeros((len(points), 3), np.float32)
    for here, per_pixel, shadows in (
        (near == VISIBLE, PER_PIXEL, False),
        (near == HIDDEN | VISIBLE, per_penumbra, True),
    ):
        pixel = np.flatnonzero(here).astype(np.int32)
        samples, places = light_samples(light, per_pixel)[:BLOCK], points.position[pixel]
        out[pixel], _ = _light(rays, points, light, samples, pixel, places, shadows)
    return smooth_penumbrae(out, points.row, alike, width)


def _light(
    rays: RayTracer,
    points: Points,
    light: Light,
    samples: NDArray[np.float64],
    at: NDArray[np.int32] | None = None,
    position: NDArray[np.float32] | None = None,
    shadows: bool = True,
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    """`light_points` at all points, or at other positions on the surface of some of them."""
    if at is None or position is None:
        at, position = np.arange(len(points), dtype=np.int32), points.position
    table = light_table([light])
    if not len(table.kind):
        return np.zeros((len(at), 3), np.float32), np.zeros(len(at), np.uint8)
    return light_points(
        rays, at, position, points.normal, points.geometric, points.view, points.model, points.row,
        points.phase, points.size, table, samples, shadows,
    )  # fmt: skip


Lamp = tuple[NDArray[np.intp], NDArray[np.float32], NDArray[np.float32]]
"""Pixels (m,) that a lamp covers, how much of each (m, 1), and its radiance there (m, 3)."""


class HasBytes(Protocol):
    """A picture, wherever it lies."""

    @property
    def nbytes(self) -> int:
        """Its size."""


Key = tuple[int | str, Light]
Picture = TypeVar("Picture", bound=HasBytes)


class LightPictures(Generic[Picture]):
    """Remembers what each light did, so that only lights that changed are computed again."""

    def __init__(self) -> None:
        self._pictures: OrderedDict[Key, Picture] = OrderedDict()
        self._bytes = 0
        self._sums: dict[int | str, tuple[frozenset[Light], NDArray[np.float64]]] = {}
        self._lamps: OrderedDict[tuple[int, Light], Lamp] = OrderedDict()

    def total(
        self: LightPictures[NDArray[np.float32]],
        what: int | str,
        lights: tuple[Light, ...],
        compute: Callable[[Light], NDArray[np.float32]],
        n: int,
    ) -> NDArray[np.float32]:
        """Sum over enabled lights of compute(light) (n, 3); see `each`."""
        on = [light for light in lights if light.enabled]
        # The room is for three kinds: of whole and of coarse pixels, and of gather samples.
        if len(on) > FEW and len(on) * 12 * n > KEPT_BYTES / 3:
            return self._changed_total(what, on, compute, n)
        out = np.zeros((n, 3), np.float32)
        for picture in self.each(what, lights, compute):
            out += picture
        return out

    def each(
        self,
        what: int | str,
        lights: tuple[Light, ...],
        compute: Callable[[Light], Picture],
    ) -> Iterator[Picture]:
        """compute(light) of the enabled lights; `what` names the kind of picture."""
        keys = {(what, light) for light in lights if light.enabled}
        for light in lights:
            if light.enabled:
                yield self._picture((what, light), compute, keys)

    def _changed_total(
        self,
        what: int | str,
        on: list[Light],
        compute: Callable[[Light], NDArray[np.float32]],
        n: int,
    ) -> NDArray[np.float32]:
        """The same for more lights than there is room for: their last sum, and what changed in it.

        Kept in double precision, from which a light can be taken away again without a trace.
        """
        wanted = frozenset(on)
        had, total = self._sums.get(what, (frozenset[Light](), np.zeros((n, 3))))
        if len(wanted ^ had) > len(wanted):
            had, total = frozenset(), np.zeros((n, 3))
        new = {(what, light) for light in wanted - had}
        for light in [light for light in on if light not in had]:
            total += self._picture((what, light), compute, new)
        for light in sorted(had - wanted, key=lambda light: light.id):
            total -= self._picture((what, light), compute, new)
        self._sums[what] = wanted, total
        return np.maximum(total, 0).astype(np.float32)

    def _picture(self, key: Key, compute: Callable[[Light], Any], wanted: set[Key]) -> Any:
        if key in self._pictures:
            self._pictures.move_to_end(key)
            return self._pictures[key]
        picture = compute(key[1])
        self._keep(key, picture, wanted)
        return picture

    def _keep(self, key: Key, picture: Picture, wanted: set[Key]) -> None:
        """Remember a picture, in place of the oldest but not of one that is wanted now."""
        while self._pictures and self._bytes + picture.nbytes > KEPT_BYTES:
            oldest = next(iter(self._pictures))
            if oldest in wanted:
                return
            self._bytes -= self._pictures.pop(oldest).nbytes
        self._pictures[key] = picture
        self._bytes += picture.nbytes

    def lamp(self, scale: int, light: Light, compute: Callable[[], Lamp]) -> Lamp:
        """The picture of a light itself."""
        key = (scale, light)
        if key not in self._lamps:
            self._lamps[key] = compute()
        self._lamps.move_to_end(key)
        while len(self._lamps) > KEPT_LAMPS:
            self._lamps.popitem(last=False)
        return self._lamps[key]
