"""The direct light of a view on the GPU: the pictures that `direct` and `view` make on the CPU."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.bvh import build_tree
from engine.backend.gl.context import Device, Uploads
from engine.backend.gl.points import Surface
from engine.backend.gl.shading import (
    HAS_SUBSAMPLES,
    Shading,
    SoftPixels,
    SoftPlaces,
    light_ends,
)
from engine.backend.gl.sums import add
from engine.light.base import Light
from engine.light.table import light_table
from engine.methods.fixed_view.direct import (
    BLOCK,
    CENTRE,
    NARROW,
    PER_COARSE_PENUMBRA_PIXEL,
    PER_PENUMBRA_PIXEL,
    PER_PIXEL,
    PER_SUBSAMPLE,
    PER_WIDE_PENUMBRA_PIXEL,
    PROBE_REACH,
    STEEP,
    WIDE,
    light_samples,
    probes,
)
from engine.methods.fixed_view.frame_buffer import FINE, Points
from engine.methods.fixed_view.light_pictures import LightPictures
from engine.methods.fixed_view.view import OVER_PIXEL, View
from engine.scene.scene import Scene


class Picture(NamedTuple):
    """A picture of one light: a buffer of (n, 3) float32."""

    buffer: Any
    nbytes: int


class Pixels(NamedTuple):
    """The pixels of a view at one scale, on the GPU.

    flags    (n,) int32  which neighbours are alike, and whether the pixel has sub-samples
    visible  (n,) int32, listed (1 + n,) int32, spare (n, 4) float32: room to work in
    """

    surface: Surface
    width: int
    flags: Any
    visible: Any
    listed: Any
    spare: Any


class GlView:
    """A view on the GPU; lights are remembered one by one, as on the CPU."""

    def __init__(
        self,
        device: Device,
        view: View,
        shading: Shading | None = None,
        room: GlView | None = None,
    ) -> None:
        """Uploads the deep frame-buffer, and the tree of its triangles unless it is given one.

        `room` is another view that is not needed any more.
        """
        self._device, self._view = device, view
        self._shading = shading or shading_of(device, view.scene)
        self._pictures: LightPictures[Picture] = LightPictures()
        buffer = view.buffer
        self._sub, self._edge = upload_points(device, buffer.sub), device.upload(buffer.edge)
        has_subsamples = np.zeros(len(buffer.centre), np.int32)
        has_subsamples[buffer.edge] = HAS_SUBSAMPLES
        self._flags = buffer.alike | has_subsamples
        self._uploaded: dict[int, Pixels] = {}
        self._room = {} if room is None else room._uploaded
        self._backdrop = Uploads(device)

    def on_points(self, points: Surface, lights: tuple[Light, ...], total: Any) -> None:
        """Add the light on points of a cloud; see `direct.light_on_points`."""

        for picture in self._each_on_points(points, lights):
            add(self._device, total, picture.buffer, points.count)

    def read_points(self, points: Surface, light: Light) -> NDArray[np.float32]:
        """(n, 3): the light of one that is on, on points of a cloud."""
        out = np.zeros((points.count, 3), np.float32)
        for picture in self._each_on_points(points, (light,)):
            picture.buffer.read_into(out, out.nbytes)
        return out

    def _each_on_points(self, points: Surface, lights: tuple[Light, ...]) -> Iterator[Picture]:
        def compute(light: Light) -> Picture:
            picture = self._picture(points.count)
            table, samples = light_table([light]), light_samples(light, 1)
            visible = self._device.room(4 * points.count)
            self._shading.points(points, table, samples, picture.buffer, visible)
            return picture

        return self._pictures.each("gather", lights, compute)

    def direct(
        self,
        lights: tuple[Light, ...],
        backdrop: NDArray[np.float32],
        scale: int,
        total: Any,
        unseen: tuple[Light, ...] = (),
    ) -> None:
        """Fill a picture with the direct light on the view samples; see `View.direct`.

        backdrop is the whole picture of what no light changes, the same array as long as it is so.
        """
        n = self._pixels(scale).surface.count
        behind = self._backdrop.of(str(scale), backdrop, lambda a: self._view.every(a, scale))
        self._device.context.copy_buffer(total, behind, 12 * n)
        light_it = self._on_buffer if scale == 1 else self._on_coarse
        for picture in self._pictures.each(scale, lights + unseen, light_it):
            add(self._device, total, picture.buffer, n)
        for light in lights:
            if light.enabled and light.has_extent:
                self._show(light, scale, total)

    def _show(self, light: Light, scale: int, total: Any) -> None:
        """See `View._lamp`."""
        pixels, eye = self._pixels(scale), self._view.scene.camera.position
        outline = OVER_PIXEL if scale == 1 else None
        args = (pixels.surface, light_table([light]), eye, pixels.width, outline)
        self._shading.lamp(*args, pixels.spare, total)

    def _on_buffer(self, light: Light) -> Picture:
        """See `direct.light_on_buffer`."""
        pixels, table = self._pixels(1), light_table([light])
        if light.has_extent:
            radiance = self._soft(pixels, light, PER_PENUMBRA_PIXEL)
        else:
            radiance = self._picture(pixels.surface.count)
            args, n = (pixels.surface, table, CENTRE), pixels.surface.count
            self._shading.points(*args, radiance.buffer, pixels.visible)
            listed = pixels.listed
            light_ends(self._device, pixels.visible, pixels.flags, pixels.width, n, listed)
            eye = self._view.scene.camera.position
            self._shading.fine(*args, listed, radiance.buffer, eye, pixels.width, FINE)
        samples = light_samples(light, PER_SUBSAMPLE)
        self._shading.sub(self._sub, table, samples, self._edge, radiance.buffer)
        return radiance

    def _on_coarse(self, light: Light) -> Picture:
        """See `direct.light_on_pixels`."""
        pixels = self._pixels(2)
        if light.has_extent:
            return self._soft(pixels, light, PER_COARSE_PENUMBRA_PIXEL)
        radiance, table = self._picture(pixels.surface.count), light_table([light])
        self._shading.points(pixels.surface, table, CENTRE, radiance.buffer, pixels.visible)
        return radiance

    def _soft(self, pixels: Pixels, light: Light, per_penumbra: int) -> Picture:
        """See `direct._soft_light`."""
        radiance, table = self._picture(pixels.surface.count), light_table([light])
        lit, penumbra = (light_samples(light, k)[:BLOCK] for k in (PER_PIXEL, per_penumbra))
        wide, every = (light_samples(light, k) for k in (PER_WIDE_PENUMBRA_PIXEL, 64))
        self._shading.soft(
            pixels.surface, table, SoftPlaces(every, wide, penumbra, lit, probes()),
            SoftPixels(pixels.flags, pixels.width, pixels.spare, PROBE_REACH, WIDE, NARROW, STEEP),
            radiance.buffer,
        )  # fmt: skip
        return radiance

    def _picture(self, n: int) -> Picture:
        return Picture(self._device.room(16 * n), 12 * n)

    def _pixels(self, scale: int) -> Pixels:
        if scale not in self._uploaded:
            device, points = self._device, self._view.points(scale)
            flags, n = self._flags if scale == 1 else self._view.coarse_alike, len(points)
            width, flags = self._view.shape(scale)[1], flags.astype(np.int32)
            room = self._room.pop(scale, None)
            if room is not None and room.surface.count == n > 0:
                device.write(room.flags, flags)
                surface = upload_points(device, points, room.surface)
                self._uploaded[scale] = room._replace(surface=surface, width=width)
            else:
                self._uploaded[scale] = Pixels(
                    upload_points(device, points),
                    width,
                    device.upload(flags),
                    device.room(4 * n),
                    device.room(4 * (1 + n)),
                    device.room(16 * n),
                )
        return self._uploaded[scale]


def shading_of(device: Device, scene: Scene) -> Shading:
    """What lights points, with the triangles of a scene in their way."""
    geometry = scene.geometry
    tree = build_tree(geometry.positions, geometry.triangles)
    return Shading(device, tree, scene.rays.epsilon)


def upload_points(device: Device, points: Points, room: Surface | None = None) -> Surface:
    """The points on the GPU; see `Surface` for `room`."""
    return Surface(
        device, points.position, points.normal, points.geometric, points.view, points.model,
        points.row, points.phase, points.size, room,
    )  # fmt: skip
