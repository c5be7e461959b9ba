"""The direct light of one scene through one camera: what every fixed-view method starts from."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numba import njit
from numpy.typing import NDArray

from engine.backend.cpu.environment import environment_on_points
from engine.backend.cpu.penumbra import alike_neighbours
from engine.backend.cpu.shading import (
    HIDDEN,
    VISIBLE,
    average,
    light_edges,
    neighbour_ray,
)
from engine.brdf import albedo
from engine.brdf.base import DIFFUSE
from engine.light import table as lights
from engine.light.base import Light
from engine.light.environment import Environment, EnvironmentTable, environment_table, is_same
from engine.light.table import light_table
from engine.methods.fixed_view import frame_buffer
from engine.methods.fixed_view.backdrop import Backdrop
from engine.methods.fixed_view.direct import light_on_buffer, light_on_pixels
from engine.methods.fixed_view.frame_buffer import FrameBuffer, Points, pixel_phase
from engine.methods.fixed_view.light_pictures import Lamp, LightPictures
from engine.numerics.borrow import borrow
from engine.numerics.frames import tangents, to_local
from engine.numerics.parallel import for_ranges
from engine.numerics.vec import dot, normalize, scale, sub, vec
from engine.scene.scene import Scene

emitted_by = lights.emitted
ENVIRONMENT_SAMPLES = 8  # from the map, and as many from the BRDF
# A lamp ends sharply and far brighter than what is behind it, so its outline gets a finer grid.
OVER_PIXEL = np.array([[(i - 1.5) / 4, (j - 1.5) / 4] for j in range(4) for i in range(4)])
ALBEDO_POINTS = 64


class Reflectance(NamedTuple):
    """Directional albedos towards the eye, k_d and k_g of Hašan et al. 2006, eq. 5, 6, times π.

    matt, gloss  (n, 3) float32
    """

    matt: NDArray[np.float32]
    gloss: NDArray[np.float32]


class View:
    """A scene, its deep frame-buffer, and the direct light on it."""

    def __init__(self, scene: Scene, buffer: FrameBuffer | None = None) -> None:
        """Casts the primary rays, well under a second per half million pixels, or is given what
        they meet.
        """
        self.scene = scene
        self.buffer: FrameBuffer = buffer or frame_buffer.build(scene)
        self.pictures: LightPictures[NDArray[np.float32]] = LightPictures()
        self.backdrop = Backdrop(scene, self.buffer)
        self._reflected: tuple[Environment | None, dict[int, NDArray[np.float32]]] = (None, {})

    @cached_property
    def _coarse(self) -> Points:
        """The centres of every second pixel of every second row."""
        width, height = self.scene.camera.width, self.scene.camera.height
        grid = np.arange(width * height).reshape(height, width)
        points = self.buffer.centre.take(np.ascontiguousarray(grid[::2, ::2]).ravel())
        height, width = self.shape(2)
        points.phase[:] = pixel_phase(width, height)
        points.size[:] *= 2
        return points

    @cached_property
    def coarse_alike(self) -> NDArray[np.uint8]:
        """(n,) of those, as `FrameBuffer.alike`."""
        points = self._coarse
        return alike_neighbours(
            points.position, points.normal, points.object, points.matt, self.shape(2)[1]
        )

    def shape(self, scale: int) -> tuple[int, int]:
        """(height, width) of a picture of every scale-th pixel."""
        return self.scene.camera.shape(scale)

    def points(self, scale: int) -> Points:
        """The pixels' centres; scale 1 or 2."""
        return self.buffer.centre if scale == 1 else self._coarse

    def direct(
        self,
        on: tuple[Light, ...],
        scale: int,
        environment: Environment | None = None,
        unseen: tuple[Light, ...] = (),
    ) -> NDArray[np.float32]:
        """Direct radiance (n, 3) float32: lights, emission, background; None is a black one.

        At scale 1 it is antialiased, at scale 2 it has one sample per pixel. Lights that are
        `unseen` shine, but not into the camera. What surfaces reflect of the environment is not in
        it.
        """
        rays, points, shining = self.scene.rays, self.points(scale), on + unseen
        if scale == 1:
            out = self.pictures.total(
                1, shining, lambda light: light_on_buffer(rays, self.buffer, light), len(points)
            )
        else:
            args = (rays, points, self.coarse_alike, self.shape(scale)[1])
            out = self.pictures.total(
                2, shining, lambda light: light_on_pixels(*args, light), len(points)
            )
        self.add_sources(out, on, scale, environment)
        return out

    def add_sources(
        self,
        out: NDArray[np.float32],
        lights: tuple[Light, ...],
        scale: int,
        environment: Environment | None,
    ) -> None:
        """Add what the camera sees of emission, environment and lights to a picture (n, 3)."""
        out += self.every(self.backdrop.picture(environment), scale)
        for light in lights:
            if light.enabled and light.has_extent:
                self._show_light(light, scale, out)

    def every(self, picture: NDArray[np.float32], scale: int) -> NDArray[np.float32]:
        """Every scale-th pixel of every scale-th row of a whole picture (n, 3)."""
        camera = self.scene.camera
        image = picture.reshape(camera.height, camera.width, 3)
        return image[::scale, ::scale].reshape(-1, 3)

    def reflected_environment(
        self, environment: Environment | None, scale: int
    ) -> NDArray[np.float32]:
        """(n, 3) float32: what surfaces reflect of an environment, by a few rays from each.

        Noisy and slow: for pictures that no precompute stands behind. The last one is kept.
        """
        known, pictures = self._reflected
        if not is_same(known, environment):
            self._reflected = known, pictures = environment, {}
        if scale not in pictures:
            table = environment_table(environment)
            pictures[scale] = self._reflect(self.points(scale), table)
            if scale == 1:
                average(self.buffer.edge, self._reflect(self.buffer.sub, table), pictures[scale])
        return pictures[scale]

    def _reflect(self, points: Points, table: EnvironmentTable) -> NDArray[np.float32]:
        return environment_on_points(
            self.scene.rays, points.position, points.normal, points.geometric, points.view,
            points.model, points.row, table, ENVIRONMENT_SAMPLES, 7,
        )  # fmt: skip

    def lamp_pixels(self, lights: Iterable[Light], scale: int) -> NDArray[np.intp]:
        """(m,): those of a picture in which lights with extent are seen themselves."""
        seen = [self._seen_lamp(light, scale)[0] for light in lights]
        return np.concatenate([np.zeros(0, np.intp), *seen])

    def _show_light(self, light: Light, scale: int, out: NDArray[np.float32]) -> None:
        pixel, cover, radiance = self._seen_lamp(light, scale)
        out[pixel] = out[pixel] * (1 - cover) + radiance

    def _seen_lamp(self, light: Light, scale: int) -> Lamp:
        return self.pictures.lamp(scale, light, lambda: self._lamp(light, scale))

    def _lamp(self, light: Light, scale: int) -> Lamp:
        """What the camera sees of a light with extent itself; at scale 1 antialiased."""
        table = light_table([light])
        points, eye = self.points(scale), np.asarray(self.scene.camera.position, np.float32)
        _, width = self.shape(scale)
        args = (table.kind[0], table.row[0], eye, points.view, points.position, points.geometric,
                points.model, width)  # fmt: skip
        ahead = np.zeros(len(points), np.bool_)
        for_ranges(_look_for_lamp, len(points), *args[:4], ahead)
        pixel = np.flatnonzero(ahead).astype(np.int32)
        seen = np.zeros((len(points), 4), np.float32)
        seen[pixel] = _see(pixel, np.zeros((1, 2)), args)
        if scale == 1:
            hit = np.full(len(points), HIDDEN, np.uint8)
            hit[pixel[seen[pixel, 3] > 0]] = VISIBLE
            edge = light_edges(hit, np.zeros(len(hit), np.bool_), width)
            seen[edge] = _see(edge, OVER_PIXEL, args)
            pixel = np.union1d(pixel, edge)
        pixel = pixel[seen[pixel, 3] > 0]
        return pixel, seen[pixel, 3:], seen[pixel, :3]

    @cached_property
    def reflectance(self) -> Reflectance:
        """Of the pixels' centres, n points: what indirect light meets."""
        return _reflectance(self.buffer.centre)

    @cached_property
    def sub_reflectance(self) -> Reflectance:
        """Of the 4m sub-samples."""
        return _reflectance(self.buffer.sub)


def _reflectance(points: Points) -> Reflectance:
    matt = points.row[:, :3].copy()
    matt[points.model < 0] = 0
    gloss = np.zeros_like(matt)
    glossy = np.flatnonzero((points.row[:, 3:6].max(axis=1, initial=0) > 0) & (points.model >= 0))
    if len(glossy):
        wo = np.zeros((len(glossy), 3))
        for_ranges(_local_views, len(glossy), points.view[glossy], points.normal[glossy], wo)
        model, row = points.model[glossy], points.row[glossy]
        whole = albedo(model, row, wo, ALBEDO_POINTS)
        gloss[glossy] = albedo(model, gloss_of(row), wo, ALBEDO_POINTS)
        matt[glossy] = np.maximum(whole - gloss[glossy], 0)
    return Reflectance(matt, gloss)


def gloss_of(row: NDArray[np.float32]) -> NDArray[np.float32]:
    """BRDF parameters (n, ROW) without their diffuse part."""
    out = row.copy()
    out[:, DIFFUSE : DIFFUSE + 3] = 0
    return out


@njit(cache=True, nogil=True)
def _local_views(start, stop, view, normal, out):
    """Fill out (n, 3) with the directions to the eye in the frames of the normals."""
    for i in range(start, stop):
        n = vec(normal, i)
        s, t = tangents(n)
        x, y, z = to_local(vec(view, i), s, t, n)
        out[i, 0], out[i, 1], out[i, 2] = normalize((x, y, max(1e-3, z)))


@njit(cache=True, nogil=True)
def _look_for_lamp(start, stop, kind, row, eye, view, ahead):
    """Whether the rays through the pixels' centres would meet the lamp in an empty scene."""
    e, lamp = vec(eye.reshape(1, 3), 0), borrow(row)
    for i in range(start, stop):
        distance, _, _, _ = emitted_by(kind, lamp, e, scale(vec(view, i), -1.0))
        ahead[i] = distance >= 0.0


def _see(
    pixel: NDArray[np.int32], offsets: NDArray[np.float64], args: tuple[Any, ...]
) -> NDArray[np.float32]:
    out = np.zeros((len(pixel), 4), np.float32)
    for_ranges(_see_lamp, len(pixel), pixel, *args, offsets, out)
    return out


@njit(cache=True, nogil=True)
def _see_lamp(
    start, stop, pixel, kind, row, eye, view, position, geometric, model, width, offsets, out
):
    """Fill out (m, 4) with a lamp's mean radiance in pixels and how much of them it covers."""
    e, lamp = vec(eye.reshape(1, 3), 0), borrow(row)
    share = 1.0 / offsets.shape[0]
    for j in range(start, stop):
        i = pixel[j]
        for s in range(offsets.shape[0]):
            d = neighbour_ray(view, i, width, offsets[s, 0], offsets[s, 1])
            distance, red, green, blue = emitted_by(kind, lamp, e, d)
            if distance < 0.0:
                continue
            g = vec(geometric, i)
            slope, height = dot(d, g), dot(sub(vec(position, i), e), g)
            far = height / slope if model[i] >= 0 and slope != 0.0 else math.inf
            if distance < far:
                out[j, 0] += red * share
                out[j, 1] += green * share
                out[j, 2] += blue * share
                out[j, 3] += share
