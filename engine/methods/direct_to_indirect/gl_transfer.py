"""A transfer on the GPU: from direct light on the gather samples to the picture, one read-back."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.gl.context import Device, Uploads, gl_errors
from engine.backend.gl.haar import Haar
from engine.backend.gl.product import Places, Rows
from engine.backend.gl.sums import add, reflect
from engine.light.base import Light
from engine.methods.direct_to_indirect.bounces import Bounces
from engine.methods.fixed_view.cloud import GatherCloud
from engine.methods.fixed_view.gl_view import GlView, upload_points
from engine.methods.fixed_view.rows import PackedRows
from engine.methods.fixed_view.tiles import run_tiles
from engine.methods.fixed_view.view import Reflectance, View

Clock = Callable[[str], AbstractContextManager[None]]
FOLDER = "methods/direct_to_indirect"


class Parts(NamedTuple):
    """What a `Transfer` hands over: all of it stays as it is from frame to frame.

    reflects     whether any glossy pixel takes up what `gloss` gathers
    tiles        by scale, places of `pixel_tiles` and `coarse_tiles`
    reflectance  by scale, of whole pixels
    sub          of the four sub-samples of edge pixels
    """

    view: View
    cloud: GatherCloud
    bounces: Bounces
    bounce: PackedRows
    final: PackedRows
    gloss: PackedRows
    reflects: bool
    tiles: dict[int, NDArray[np.int32]]
    reflectance: dict[int, Reflectance]
    sub: Reflectance


class Standing(NamedTuple):
    """What no light changes: the same arrays until the environment is another.

    backdrop            (h w, 3)  emission and background of the whole picture
    bounced             (n_g, 3)  in wavelets, all bounces of emission and environment
    arriving, mirrored  (n, 3)    what arrives from it at matt and glossy parts of view samples
    suns                          of its map, which the camera sees in the backdrop
    """

    backdrop: NDArray[np.float32]
    bounced: NDArray[np.float32]
    arriving: NDArray[np.float32] | None = None
    mirrored: NDArray[np.float32] | None = None
    suns: tuple[Light, ...] = ()


class Albedos(NamedTuple):
    """A `Reflectance` on the GPU."""

    matt: Any
    gloss: Any


class GlTransfer:
    """Draws what `Transfer` draws, by the same steps."""

    def __init__(self, device: Device, parts: Parts) -> None:
        """Uploads everything that frames have in common. Raises BackendError where it cannot."""
        self._device, self._parts = device, parts
        with gl_errors():
            self._upload()
            device.check()

    def _upload(self) -> None:
        device, parts = self._device, self._parts
        self._view = GlView(device, parts.view)
        self._points = upload_points(device, parts.cloud.points)
        self._environment = Uploads(device)
        self._reflected = device.upload(parts.bounces.reflected)
        self._bounce, self._final = Rows(device, *parts.bounce), Rows(device, *parts.final)
        self._gloss = Rows(device, *parts.gloss) if parts.reflects else None
        self._runs = Places(device, run_tiles(len(parts.cloud)))
        self._places = {scale: Places(device, tiles) for scale, tiles in parts.tiles.items()}
        self._albedos = {
            scale: Albedos(*map(device.upload, whole)) for scale, whole in parts.reflectance.items()
        }
        self._sub = Albedos(*map(device.upload, parts.sub))
        self._edge = device.upload(parts.view.buffer.edge)
        self._donor = device.upload(parts.view.buffer.donor)
        # Room to work in.
        samples, pixels = len(parts.cloud), len(parts.view.points(1))
        self._haar = Haar(device, samples)
        self._first, self._g, self._light, self._total = (
            device.floats(3 * samples) for _ in range(4)
        )
        self._arriving, self._mirrored = (device.floats(3 * pixels) for _ in range(2))
        # The picture, and behind it three numbers for every bounce.
        self._image = device.floats(3 * (pixels + parts.bounces.count + 1))

    def draw(
        self, lights: tuple[Light, ...], standing: Standing, scale: int, clock: Clock
    ) -> tuple[NDArray[np.float32], list[NDArray[np.float64]]]:
        """(picture (n, 3), power (3,) of the light after each bounce): see `Bounces.unsure`.

        Raises BackendError where GL fails.
        """
        with gl_errors():
            return self._draw(lights, standing, scale, clock)

    def _draw(
        self, lights: tuple[Light, ...], standing: Standing, scale: int, clock: Clock
    ) -> tuple[NDArray[np.float32], list[NDArray[np.float64]]]:
        self._device.require_own_thread()
        self._device.context.gc()
        n = len(self._parts.view.points(scale))
        with clock("gather_direct"):
            self._first.clear()
            self._view.on_points(self._points, lights + standing.suns, self._first)
        with clock("bounces"):
            self._bounce_all(n)
            self._add("bounced", standing.bounced, self._total)
        with clock("final_gather"):
            places = self._places[scale]
            self._final.multiply(self._total, places, self._arriving)
            self._add(f"arriving {scale}", standing.arriving, self._arriving)
            if self._gloss is not None:
                self._gloss.multiply(self._total, places, self._mirrored)
                self._add(f"mirrored {scale}", standing.mirrored, self._mirrored)
        with clock("view_direct"):
            args = (standing.backdrop, scale, self._image, standing.suns)
            self._view.direct(lights, *args)
        with clock("compose"):
            self._compose(scale, n)
        with clock("read_back"):
            count = self._parts.bounces.count + 1
            numbers = np.zeros((n + count, 3), np.float32)
            self._image.read_into(numbers, numbers.nbytes)
        self._device.check()
        return numbers[:n], list(numbers[n:].astype(np.float64))

    def first(self) -> NDArray[np.float32]:
        """(n_g, 3): what the gather samples of the last picture reflect of its lights first.

        Raises BackendError where GL fails, as `first_of`.
        """
        out = np.zeros((len(self._parts.cloud), 3), np.float32)
        with gl_errors():
            self._first.read_into(out, out.nbytes)
        return out

    def first_of(self, light: Light) -> NDArray[np.float32]:
        """(n_g, 3): what the gather samples reflect first of one light."""
        with gl_errors():
            return self._view.read_points(self._points, light)

    def _bounce_all(self, n: int) -> None:
        """`_total` of `_first`, and the power of every bounce behind the picture's n pixels."""
        bounces, samples = self._parts.bounces, len(self._parts.cloud)
        self._haar.forward(self._first, self._light)
        self._copy(self._light, self._total)
        self._copy(self._light, self._image, 12, 12 * n)
        for k, gain in enumerate(bounces.of_lights.gains, 1):
            self._bounce.multiply(self._light, self._runs, self._g)
            reflect(self._device, self._g, self._reflected, samples, gain)
            self._haar.forward(self._g, self._light)
            add(self._device, self._total, self._light, samples)
            self._copy(self._light, self._image, 12, 12 * (n + k))
        if bounces.count:
            add(self._device, self._total, self._light, samples, tuple(bounces.of_lights.tail))

    def _compose(self, scale: int, n: int) -> None:
        mirrored = self._arriving if self._gloss is None else self._mirrored
        light = {"b_arriving": self._arriving, "b_mirrored": mirrored, "b_image": self._image}
        whole, edges = self._albedos[scale], len(self._parts.view.buffer.edge)
        program = self._device.program(f"{FOLDER}/compose.glsl")
        program.run(3 * n, {**light, "b_matt": whole.matt, "b_gloss": whole.gloss}, u_count=n)
        if scale == 1:
            own = {
                "b_matt": self._sub.matt, "b_gloss": self._sub.gloss,
                "b_edge": self._edge, "b_donor": self._donor,
            }  # fmt: skip
            program = self._device.program(f"{FOLDER}/compose_edges.glsl")
            program.run(edges, {**light, **own}, u_edges=edges)

    def _add(self, name: str, array: NDArray[np.float32] | None, total: Any) -> None:
        if array is not None:
            add(self._device, total, self._environment.of(name, array), len(array))

    def _copy(self, source: Any, target: Any, size: int = -1, offset: int = 0) -> None:
        self._device.context.copy_buffer(target, source, size, write_offset=offset)
