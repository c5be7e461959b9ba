"""The finished transport and the frames that it makes: `glossy_prt` §4.3.

A new environment is a light vector, one sparse product for the vectors of all vertices, and a
picture; a new camera is a picture alone.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.backend.choice import Backend, wanted
from engine.backend.cpu.vectors import multiply_vectors
from engine.diagnosis import Diagnosis
from engine.light.cube_light import CubeLight
from engine.light.environment import Environment, is_same
from engine.methods.base import Frame, MaterialFit, require_supported
from engine.methods.clock import Clock
from engine.methods.glossy_prt.fits import Fits
from engine.methods.glossy_prt.settings import Settings
from engine.methods.glossy_prt.terms import Terms
from engine.methods.glossy_prt.vertices import Vertices
from engine.methods.glossy_prt.view import View, look, shade
from engine.methods.glossy_prt.views import stack_maps
from engine.numerics.wavelet_vectors import WaveletVectors
from engine.scene.camera import Camera
from engine.scene.edits import Edits, edited_camera, edited_environment
from engine.scene.scene import Scene

NAME = "glossy_prt"
NO_GL = Diagnosis("gl_unavailable", "The CPU draws: this method has no GL backend yet.")
SAID = 0.02  # of all light: less is not worth a warning


class Prt:
    """L_o = h · (T L) at every pixel (eq. 5)."""

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        vertices: Vertices,
        terms: list[Terms],
        direct: list[WaveletVectors],
        bounced: list[WaveletVectors] | None,
        left: float,
        fits: Fits,
    ) -> None:
        """terms, direct, bounced and fits are of the scene's materials; left is the part of all
        light that passes which were not made would bring.
        """
        self.scene, self._settings = scene, settings
        self.vertices, self.terms, self.direct, self.bounced = vertices, terms, direct, bounced
        self._sets = [[(v.start, v) for v in vectors] for vectors in (direct, bounced or ())]
        self._maps = stack_maps(terms, np.bincount(vertices.material, minlength=len(terms)))
        self._light = CubeLight(settings.light_texels)
        self._lit: tuple[Environment | None, NDArray[np.float32]] | None = None
        self._view: tuple[Camera, int, View] | None = None
        said = (_local_lights(scene), _truncated(left))
        self._of_scene = (*(d for d in said if d is not None), *fits.said)
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
        return sum(a.nbytes for vectors in self._sets for _, v in vectors for a in v)

    @property
    def fits(self) -> tuple[MaterialFit, ...]:
        """How well the terms fit the materials that something is made of."""
        return self._fits

    def relight(self, edits: Edits, scale: int = 1, backend: Backend | None = None) -> Frame:
        """See `engine.methods.base.Product.relight`."""
        require_supported(NAME, edits)
        clock = Clock()
        scene = self.scene
        environment = edited_environment(scene.environment, edits.environment, Path(scene.folder))
        camera = edited_camera(scene.camera, edits.camera)
        with clock("transport"):
            lit = self.lit(environment)
        with clock("view"):
            view = self._seen(camera, scale)
        with clock("shade"):
            args = (scene, self.vertices, self._maps, lit)
            image = shade(*args, view.centre, environment)
            if len(view.edge):
                sub = shade(*args, view.sub, environment)
                image[view.edge] = sub.reshape(-1, 4, 3).mean(axis=1)
        notices = (NO_GL, *self._of_scene) if wanted(backend) == "gl" else self._of_scene
        return Frame(image.reshape(*view.shape, 3), clock.timings(), notices)

    def lit(self, environment: Environment | None) -> NDArray[np.float32]:
        """(rows, 3) float32: light-dependent vectors of all vertices; the last ones are kept."""
        if self._lit is None or not is_same(self._lit[0], environment):
            self._lit = environment, self.multiply(self._light.coefficients(environment))
        return self._lit[1]

    def multiply(self, light: NDArray[np.float32]) -> NDArray[np.float32]:
        """(rows, 3) float32: all vectors times the Haar coefficients (6 n², 3) of a light."""
        each = zip(self.direct, self.terms, strict=True)
        out = np.zeros((sum(len(v.length) * t.count for v, t in each), 3), np.float32)
        for vectors in self._sets:
            for m, (start, v) in enumerate(vectors):
                channels = v.scale.shape[1] // self.terms[m].count
                part = multiply_vectors(start, *v[1:], light, channels)
                out[self._maps.first[m] : self._maps.first[m] + len(part)] += part
        return out

    def _seen(self, camera: Camera, scale: int) -> View:
        if self._view is None or self._view[:2] != (camera, scale):
            self._view = camera, scale, look(self.scene, camera, scale)
        return self._view[2]


def _local_lights(scene: Scene) -> Diagnosis | None:
    if not any(light.enabled for light in scene.lights):
        return None
    return Diagnosis(
        "lights_left_out",
        "This method carries light from the environment alone: the scene's lamps are left out. "
        "direct_to_indirect carries them, for a camera that stands still.",
    )


def _truncated(left: float) -> Diagnosis | None:
    if left < SAID:
        return None
    return Diagnosis(
        "bounces_truncated",
        f"Light that bounces more often than it was followed would add {100 * left:.0f} % or "
        "more to what there is: set bounces higher.",
        left,
    )
