"""Direct light on the deep frame-buffer and on the gather cloud, one light at a time.

Light is additive, so every light has a picture of its own. The pictures of lights that did not
change are kept (§5 of Hašan et al. 2006 caches all lights but the moving one).
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from engine.backend.cpu.shading import VISIBLE, light_edges, light_points, on_tangent_planes
from engine.light.base import Light
from engine.light.table import LightTable, light_table
from engine.methods.fixed_view.frame_buffer import FINE, FrameBuffer, Points
from engine.scene.rays import RayTracer

# A light with extent is lit from a 4 x 4 grid of its points, the same for every pixel: shadows are
# sums of 16 sharp ones, which band a little but never flicker.
AREA_GRID = 4
KEPT_PICTURES = 24


def light_samples(light: Light) -> list[tuple[float, float]]:
    """The sample points (u1, u2) of a light: one, or a grid where it has extent."""
    if not light.has_extent:
        return [(0.5, 0.5)]
    centres = (np.arange(AREA_GRID) + 0.5) / AREA_GRID
    return [(float(a), float(b)) for b in centres for a in centres]


def light_on_points(rays: RayTracer, points: Points, light: Light) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 with hard-edged visibility, averaged over samples."""
    table = light_table([light])
    out = np.zeros((len(points), 3), np.float32)
    samples = light_samples(light) if len(table.kind) else []
    for u in samples:
        radiance, visible = _light(rays, points, table, u)
        radiance[visible != VISIBLE] = 0
        out += radiance
    return out / np.float32(max(1, len(samples)))


def light_on_pixels(rays: RayTracer, buffer: FrameBuffer, light: Light) -> NDArray[np.float32]:
    """Reflected radiance (n, 3) float32 per pixel, antialiased as if four times supersampled."""
    table = light_table([light])
    out = np.zeros((len(buffer.centre), 3), np.float32)
    if not len(table.kind):
        return out
    centre = buffer.centre
    skip = np.zeros(len(centre), np.bool_)
    skip[buffer.edge] = True
    samples = light_samples(light)
    for u in samples:
        radiance, visible = _light(rays, centre, table, u)
        radiance[visible != VISIBLE] = 0

        # Where light ends within a pixel, light its tangent plane at a finer grid of places.
        pixel = light_edges(visible, skip, buffer.camera.width)
        fine = centre.take(np.repeat(pixel, len(FINE)))
        fine.position[:] = on_tangent_planes(
            pixel, buffer.camera.position, centre.view, centre.position, centre.geometric,
            buffer.camera.width, FINE,
        )  # fmt: skip
        each, seen = _light(rays, fine, table, u)
        each[seen != VISIBLE] = 0
        radiance[pixel] = each.reshape(-1, len(FINE), 3).mean(axis=1)
        out += radiance
    out /= np.float32(len(samples))
    sub = light_on_points(rays, buffer.sub, light)
    out[buffer.edge] = sub.reshape(-1, 4, 3).mean(axis=1)
    return out


def _light(
    rays: RayTracer, points: Points, table: LightTable, u: tuple[float, float]
) -> tuple[NDArray[np.float32], NDArray[np.uint8]]:
    return light_points(
        rays, points.position, points.normal, points.geometric, points.view, points.model,
        points.row, table.kind[0], table.row[0], u,
    )  # fmt: skip


Lamp = tuple[NDArray[np.intp], NDArray[np.float32], NDArray[np.float32]]
"""Pixels (m,) that a lamp covers, how much of each (m, 1), and its radiance there (m, 3)."""


class LightPictures:
    """Remembers what each light did, so that only lights that changed are computed again."""

    def __init__(self) -> None:
        self._pictures: OrderedDict[tuple[int | str, Light], NDArray[np.float32]] = OrderedDict()
        self._lamps: OrderedDict[tuple[int, Light], Lamp] = OrderedDict()

    def total(
        self,
        what: int | str,
        lights: tuple[Light, ...],
        compute: Callable[[Light], NDArray[np.float32]],
        n: int,
    ) -> NDArray[np.float32]:
        """Sum over enabled lights of compute(light) (n, 3); `what` names the kind of picture."""
        out = np.zeros((n, 3), np.float32)
        on = [light for light in lights if light.enabled]
        for light in on:
            key = (what, light)
            picture = self._pictures.get(key)
            if picture is None:
                picture = compute(light)
                if len(on) * 3 <= KEPT_PICTURES:
                    self._pictures[key] = picture
            else:
                self._pictures.move_to_end(key)
            out += picture
        while len(self._pictures) > KEPT_PICTURES:
            self._pictures.popitem(last=False)
        return out

    def lamp(self, scale: int, light: Light, compute: Callable[[], Lamp]) -> Lamp:
        """The picture of a light itself."""
        key = (scale, light)
        if key not in self._lamps:
            self._lamps[key] = compute()
        self._lamps.move_to_end(key)
        while len(self._lamps) > KEPT_PICTURES:
            self._lamps.popitem(last=False)
        return self._lamps[key]
