"""The finished transport and the frames that it makes: `glossy_prt` §4.3.

A new environment is a light vector, one sparse product for the vectors of all vertices, and a
picture; a new camera is a picture alone.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from engine.backend.choice import Backend, GlFirst
from engine.backend.cpu.vectors import Factor
from engine.backend.gl.context import Device
from engine.backend.gl.vectors import Part, StoredVectors
from engine.diagnosis import Diagnosis
from engine.light.cube_light import CubeLight
from engine.light.environment import Environment, is_same
from engine.methods.base import Frame, MaterialFit, require_supported
from engine.methods.clock import Clock
from engine.methods.free_view import View, look
from engine.methods.glossy_prt.fits import Fits
from engine.methods.glossy_prt.gl_prt import GlPrt
from engine.methods.glossy_prt.measured import Measured, hardness, left_out, said_of
from engine.methods.glossy_prt.settings import Settings
from engine.methods.glossy_prt.shade import Responses, respond, shade
from engine.methods.glossy_prt.terms import Terms
from engine.methods.glossy_prt.vertices import Vertices
from engine.methods.glossy_prt.views import stack_maps
from engine.numerics.cluster_basis import Clusters
from engine.numerics.cube_map import FACES
from engine.numerics.wavelet_vectors import WaveletVectors
from engine.scene.camera import Camera
from engine.scene.edits import Edits, edited_camera, edited_environment
from engine.scene.scene import Scene

NAME = "glossy_prt"


Stored = WaveletVectors | Clusters


class Transport(NamedTuple):
    """What a precompute found.

    direct    transport vectors of every material of the scene
    bounced   the same of what bounces; empty where no bounce was asked for
    measured  how far off it is
    """

    direct: list[Stored]
    bounced: list[Stored]
    measured: Measured


class Prt:
    """L_o = h · (T L) at every pixel (eq. 5)."""

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        vertices: Vertices,
        terms: list[Terms],
        transport: Transport,
        fits: Fits,
    ) -> None:
        """terms and fits are those of the scene's materials."""
        self.scene, self._settings = scene, settings
        self.vertices, self.terms, self.transport = vertices, terms, transport
        count = np.bincount(vertices.material, minlength=len(terms))
        self._maps = stack_maps(terms, count)
        self._rows = int(count @ self._maps.terms)
        self._factors = [
            (m, Factor(stored, terms[m].count))
            for part in (transport.direct, transport.bounced)
            for m, stored in enumerate(part)
        ]
        self._light = CubeLight(settings.light_texels)
        self._lit: tuple[Environment | None, NDArray[np.float32]] | None = None
        self._view: tuple[Camera, int, View, tuple[Responses, Responses]] | None = None
        self._backend = GlFirst()
        # What draws on the GPU, from the first frame that it draws.
        self._gl: GlPrt | None = None
        self._of_scene = (*left_out(scene), *fits.said)
        self._of_light: tuple[Environment | None, tuple[Diagnosis, ...]] | None = None
        self._fits = fits.materials

    @property
    def method(self) -> str:
        """`glossy_prt`."""
        return NAME

    @property
    def settings(self) -> Settings:
        """What it was made with."""
        return self._settings

    @property
    def bytes(self) -> int:
        """Bytes of the transport vectors."""
        return sum(factor.bytes for _, factor in self._factors)

    @property
    def fits(self) -> tuple[MaterialFit, ...]:
        """How well the terms fit the materials that something is made of."""
        return self._fits

    def relight(self, edits: Edits, scale: int = 1, backend: Backend | None = None) -> Frame:
        """See `engine.methods.base.Product.relight`."""
        require_supported(NAME, edits)
        environment = edited_environment(
            self.scene.environment, edits.environment, Path(self.scene.folder)
        )
        camera = edited_camera(self.scene.camera, edits.camera)
        (image, clock), notices = self._backend.draw(
            backend,
            lambda device: self._by_gl(device, environment, camera, scale),
            lambda: self._by_cpu(environment, camera, scale),
        )
        if self._backend.failed:
            self._gl = None
        return Frame(image, clock.timings(), (*notices, *self._of_scene, *self._said(environment)))

    def _said(self, environment: Environment | None) -> tuple[Diagnosis, ...]:
        """What to say of the light of an environment, however it is turned; the last is kept."""
        if self._of_light is None or not _is_as_hard(self._of_light[0], environment):
            hard = hardness(self._light.radiance(environment), self._settings.light_texels)
            self._of_light = environment, tuple(said_of(self.transport.measured, hard))
        return self._of_light[1]

    def _by_gl(
        self, device: Device, environment: Environment | None, camera: Camera, scale: int
    ) -> tuple[NDArray[np.float32], Clock]:
        clock = Clock(device.context.finish)
        self._gl = self._gl or self._on_gl(device)
        return self._gl.draw(environment, camera, scale, clock), clock

    def _by_cpu(
        self, environment: Environment | None, camera: Camera, scale: int
    ) -> tuple[NDArray[np.float32], Clock]:
        clock = Clock()
        with clock("transport"):
            lit = self.lit(environment)
        with clock("view"):
            view, (of_centre, of_sub) = self._seen(camera, scale)
        with clock("shade"):
            args = (self.scene, self.vertices, self._maps)
            image = shade(*args, lit, view.centre, of_centre, environment)
            if len(view.edge):
                sub = shade(*args, lit, view.sub, of_sub, environment)
                image[view.edge] = sub.reshape(-1, 4, 3).mean(axis=1)
        return image.reshape(*view.shape, 3), clock

    def _on_gl(self, device: Device) -> GlPrt:
        first, texels = self._maps.first.tolist(), FACES * self._settings.light_texels**2
        vectors = StoredVectors(device, texels, *(
            [Part(first[m], self.terms[m].count, stored) for m, stored in enumerate(part)]
            for part in (self.transport.direct, self.transport.bounced)
        ))  # fmt: skip
        return GlPrt(
            device, self.scene, self.vertices, self._maps,
            lambda environment: vectors.multiply(self._light.coefficients(environment)),
        )  # fmt: skip

    def lit(self, environment: Environment | None) -> NDArray[np.float32]:
        """(rows, 3) float32: light-dependent vectors of all vertices; the last ones are kept."""
        if self._lit is None or not is_same(self._lit[0], environment):
            self._lit = environment, self.multiply(self._light.coefficients(environment))
        return self._lit[1]

    def multiply(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """(rows, 3) float32: all vectors times the Haar coefficients (6 n², 3) of a light."""
        out = np.zeros((self._rows, 3), np.float32)
        for m, factor in self._factors:
            first = self._maps.first[m]
            last = first + factor.vertices * factor.terms
            factor.add_product(light, out[first:last].reshape(-1, factor.terms, 3))
        return out

    def _seen(self, camera: Camera, scale: int) -> tuple[View, tuple[Responses, Responses]]:
        if self._view is None or self._view[:2] != (camera, scale):
            view = look(self.scene, camera, scale)
            args = (self.scene, self.vertices, self._maps)
            responses = respond(*args, view.centre), respond(*args, view.sub)
            self._view = camera, scale, view, responses
        return self._view[2:]


def _is_as_hard(a: Environment | None, b: Environment | None) -> bool:
    """Whether two environments are the same but for a turn and a factor."""
    if a is None or b is None:
        return a is b
    same = a.description.area_light == b.description.area_light
    return same and a.radiance is b.radiance
