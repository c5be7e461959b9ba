"""The finished transport and the frames that it makes: `glossy_prt` §4.3.

A new environment is a light vector, one sparse product for the vectors of all vertices, and a
picture; a new camera is a picture alone.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from engine.backend.choice import Backend
from engine.backend.cpu.vectors import multiply_vectors
from engine.diagnosis import Diagnosis
from engine.light.cube_light import CubeLight
from engine.light.environment import Environment, is_same
from engine.methods.base import Frame, require_supported
from engine.methods.clock import Clock
from engine.methods.glossy_prt.settings import Settings
from engine.methods.glossy_prt.terms import Terms
from engine.methods.glossy_prt.vertices import Vertices
from engine.methods.glossy_prt.view import View, look, shade, stack_maps
from engine.numerics.wavelet_vectors import WaveletVectors
from engine.scene.camera import Camera
from engine.scene.edits import Edits, edited_camera, edited_environment
from engine.scene.scene import Scene

NAME = "glossy_prt"


class Prt:
    """L_o = h · (T L) at every pixel (eq. 5)."""

    def __init__(
        self,
        scene: Scene,
        settings: Settings,
        vertices: Vertices,
        terms: list[Terms],
        vectors: list[WaveletVectors],
    ) -> None:
        """terms and vectors are those of the scene's materials."""
        self.scene, self._settings = scene, settings
        self.vertices, self.terms, self.vectors = vertices, terms, vectors
        self._starts = [v.start for v in vectors]
        rows = np.cumsum([0] + [len(v.length) for v in vectors])
        self._rows = rows
        counts = np.bincount(vertices.material, minlength=len(terms))
        firsts = np.concatenate([[0], np.cumsum(counts)])
        self._maps = stack_maps(terms, list(rows[:-1]), list(firsts[:-1]))
        self._light = CubeLight(settings.light_texels)
        self._lit: tuple[Environment | None, NDArray[np.float32]] | None = None
        self._view: tuple[Camera, int, View] | None = None
        self._of_scene = tuple(d for d in (_local_lights(scene),) if d is not None)

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
        return sum(array.nbytes for vectors in self.vectors for array in vectors)

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
        return Frame(image.reshape(*view.shape, 3), clock.timings(), self._of_scene)

    def lit(self, environment: Environment | None) -> NDArray[np.float32]:
        """(rows, 3) float32: light-dependent vectors of all vertices; the last ones are kept."""
        if self._lit is None or not is_same(self._lit[0], environment):
            out = np.zeros((self._rows[-1], 3), np.float32)
            light = self._light.coefficients(environment)
            for row, start, vectors in zip(self._rows, self._starts, self.vectors, strict=False):
                part = multiply_vectors(start, *vectors[1:], light)
                out[row : row + len(part)] = part
            self._lit = environment, out
        return self._lit[1]

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
