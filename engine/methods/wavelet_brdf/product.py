"""Pictures straight from the codes: eq. 1, for any light, camera and material.

What a camera sees is found once (`surface`); a picture is then the light of every lamp on it, with
shadows, by the same code that lights the fixed views of other methods. The BRDF of a pixel is
`engine.brdf.measured` at the pixel's level.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.backend.choice import Backend, GlFirst
from engine.backend.gl.bvh import build_tree
from engine.backend.gl.context import Device, gl_errors
from engine.backend.gl.shading import Shading
from engine.brdf.base import Material
from engine.brdf.measured import Measured
from engine.diagnosis import Diagnosis
from engine.light.base import Light
from engine.methods.base import Frame, MaterialFit, require_supported, silent
from engine.methods.clock import Clock
from engine.methods.fixed_view.gl_view import GlView
from engine.methods.fixed_view.view import View
from engine.methods.light_shares import light_shares
from engine.methods.wavelet_brdf import levels
from engine.methods.wavelet_brdf.codes import NAME, Codes, codes_of
from engine.methods.wavelet_brdf.glitter import scatter
from engine.methods.wavelet_brdf.limits import fits_of, said_of, said_of_facets
from engine.methods.wavelet_brdf.settings import Settings
from engine.methods.wavelet_brdf.surface import buffer_of
from engine.scene.camera import Camera
from engine.scene.edits import Edits, edited_camera, edited_lights, edited_materials
from engine.scene.rays import RayTracer
from engine.scene.scene import Scene
from engine.store import Store


@dataclass(frozen=True, eq=False)
class _Seen:
    """What was drawn last: a camera, a scale, materials, what that shows, and it on the GPU."""

    camera: Camera
    scale: int
    codes: Codes
    view: View
    on_gl: GlView | None = None


class Wavelets:
    """Reflected light of lamps by encoded BRDFs; no light is reflected twice."""

    def __init__(self, scene: Scene, settings: Settings, codes: Codes, store: Store) -> None:
        """codes are those of the scene's materials; others that edits bring go to the store."""
        self.scene, self._settings, self._store = scene, settings, store
        self._used = np.unique(scene.geometry.material).tolist()
        self._codes: tuple[tuple[Material, ...], list[int], Codes] = (
            scene.materials, self._used, codes,
        )  # fmt: skip
        self._own, self._shares = codes, light_shares(scene)
        self._lit = scene if settings.shadows else _without_shadows(scene)
        self._seen: _Seen | None = None
        self._shading: Shading | None = None
        self._backend = GlFirst()

    @property
    def method(self) -> str:
        """`wavelet_brdf`."""
        return NAME

    @property
    def settings(self) -> Settings:
        """What it was made with."""
        return self._settings

    @property
    def bytes(self) -> int:
        """Size of the codes that the scene's materials have."""
        return sum({id(code): code.bytes for code in self._own.each if code is not None}.values())

    @property
    def fits(self) -> tuple[MaterialFit, ...]:
        """How well the codes fit the materials that something is made of."""
        return fits_of(self.scene, self._own, self._used)

    def refitted(self, materials: tuple[Material, ...]) -> tuple[MaterialFit, ...]:
        """The same of other materials; from any thread."""
        args = (self._settings, self._store, self._used, silent)
        return fits_of(self.scene, codes_of(self.scene, materials, *args), self._used)

    def retuned(self, settings: Settings) -> Wavelets:
        """The same with other settings of RUN_TIME; it shares the codes."""
        return Wavelets(self.scene, settings, self._own, self._store)

    def relight(self, edits: Edits, scale: int = 1, backend: Backend | None = None) -> Frame:
        """See `engine.methods.base.Product.relight`."""
        require_supported(NAME, edits)
        camera = edited_camera(self.scene.camera, edits.camera)
        lights = edited_lights(self.scene.lights, edits.lights, self.scene.folder)
        materials = edited_materials(self.scene, edits.materials)

        def draw(device: Device | None) -> tuple[NDArray[np.float32], Clock]:
            clock = Clock() if device is None else Clock(device.context.finish)
            return self._draw(camera, lights, materials, scale, clock, device), clock

        (image, clock), notices = self._backend.draw(backend, draw, lambda: draw(None))
        if self._backend.failed and self._seen is not None:
            self._seen, self._shading = replace(self._seen, on_gl=None), None
        return Frame(image, clock.timings(), (*notices, *self._said(image)))

    def _said(self, image: NDArray[np.float32]) -> tuple[Diagnosis, ...]:
        materials, _, codes = self._codes
        said = tuple(said_of(self.scene, materials, codes, self._used, self._shares))
        if self._seen is None or self._seen.scale > 1 or self._settings.show == "levels":
            return said
        return (*said, *said_of_facets(scatter(self._seen.view.buffer.centre, image)))

    def _draw(
        self, camera: Camera, lights: tuple[Light, ...], materials: tuple[Material, ...],
        scale: int, clock: Clock, device: Device | None,
    ) -> NDArray[np.float32]:  # fmt: skip
        """(height, width, 3) float32 radiance."""
        with clock("codes"):
            codes = self._codes_of(materials, scale)
        with clock("view"):
            seen = self._look(camera, scale, codes, device)
        view, environment = seen.view, self.scene.environment
        with clock("light"):
            if self._settings.show == "levels":
                image = levels.picture_of(view.buffer.centre, codes.each)
            elif seen.on_gl is None or device is None:
                image = view.direct(lights, 1, environment)
            else:
                image = self._on_gl(device, seen.on_gl, view, lights)
        return image.reshape(*camera.shape(scale), 3)

    def _codes_of(self, materials: tuple[Material, ...], scale: int) -> Codes:
        """A model under the hand is drawn by its formula: a code takes longer than a picture."""
        known, encoded, codes = self._codes
        wanted = self._used
        if scale > 1:
            wanted = [
                m for m in wanted
                if isinstance(materials[m], Measured) or (m in encoded and materials[m] == known[m])
            ]  # fmt: skip
        if materials != known or not set(wanted) <= set(encoded):
            args = (self._settings, self._store, wanted, silent)
            codes = codes_of(self.scene, materials, *args)
            self._codes = materials, wanted, codes
        return codes

    def _look(self, camera: Camera, scale: int, codes: Codes, device: Device | None) -> _Seen:
        seen = self._seen
        drawn = None if seen is None else seen.on_gl
        known = seen is not None and (seen.camera, seen.scale) == (camera, scale)
        if seen is None or not known or seen.codes is not codes:
            room = None if seen is None else seen.view.buffer
            self._seen = None  # whose points make room for the new ones
            buffer = buffer_of(self.scene, camera, scale, codes, self._settings, room)
            lit = self._lit.with_camera(buffer.camera)
            seen = _Seen(camera, scale, codes, View(_with_table(lit, codes), buffer))
        if device is not None and seen.on_gl is None:
            with gl_errors():
                device.require_own_thread()
                self._shading = self._shading or self._shading_on(device)
                on_gl = GlView(device, seen.view, self._shading, drawn)
            seen = _Seen(camera, scale, codes, seen.view, on_gl)
        self._seen = seen
        return seen

    def _shading_on(self, device: Device) -> Shading:
        geometry = self.scene.geometry
        triangles = geometry.triangles[: None if self._settings.shadows else 0]
        return Shading(device, build_tree(geometry.positions, triangles), self.scene.rays.epsilon)

    def _on_gl(
        self, device: Device, drawn: GlView, view: View, lights: tuple[Light, ...]
    ) -> NDArray[np.float32]:
        with gl_errors():
            device.context.gc()
            image = np.zeros((len(view.buffer.centre), 3), np.float32)
            total = device.room(16 * len(image))
            drawn.direct(lights, view.backdrop.picture(self.scene.environment), 1, total)
            total.read_into(image, image.nbytes)
            device.check()
            return image


class _Unhindered:
    """Rays that nothing is in the way of."""

    def __init__(self, rays: RayTracer) -> None:
        self.epsilon = rays.epsilon

    def occluded(self, origin: Any, direction: Any, limit: Any) -> NDArray[np.bool_]:
        """(n,) False."""
        return np.zeros(len(origin), np.bool_)


def _without_shadows(scene: Scene) -> Scene:
    bare = replace(scene)
    bare.__dict__.update(rays=_Unhindered(scene.rays), diagonal=scene.diagonal)
    return bare


def _with_table(scene: Scene, codes: Codes) -> Scene:
    changed = replace(scene, material_table=codes.table)
    changed.__dict__.update(rays=scene.rays, diagonal=scene.diagonal)
    return changed
