"""Direct light alone: the picture that needs no precompute, shown until there is a better one."""

from __future__ import annotations

import time
from pathlib import Path

from engine.diagnosis import Diagnosis
from engine.errors import EditNotSupported
from engine.methods.base import Frame
from engine.methods.fixed_view.view import View
from engine.scene.edits import Edits, edited_environment, edited_lights
from engine.scene.scene import Scene

PENDING = Diagnosis(
    "indirect_pending",
    "Only direct light is shown: the indirect light of this view has not been precomputed yet.",
)


LAMPS_ALONE = Diagnosis(
    "codes_pending",
    "The materials have not been encoded yet: they are drawn at the finest detail.",
)


class DirectPreview:
    """A view that is ready in about a second; takes edits of lights and environment."""

    def __init__(self, scene: Scene, lamps_alone: bool = False) -> None:
        """Builds the deep frame-buffer.

        lamps_alone  whether the environment is seen and does not shine, for a method that does
                     without its light and without indirect light
        """
        self.view, self._lamps_alone = View(scene), lamps_alone

    def relight(self, edits: Edits, scale: int = 1) -> Frame:
        """The picture in direct light; see `engine.methods.base.Product.relight`."""
        start = time.perf_counter()
        for key in sorted(edits.touched() - {"lights", "environment"}):
            raise EditNotSupported(
                "the preview takes edits of lights and environment only", field=key
            )
        scene = self.view.scene
        lights = edited_lights(scene.lights, edits.lights, scene.folder)
        environment = edited_environment(scene.environment, edits.environment, Path(scene.folder))
        image = self.view.direct(lights, scale, environment)
        if environment is not None and not self._lamps_alone:
            image += self.view.reflected_environment(environment, scale)
        said = LAMPS_ALONE if self._lamps_alone else PENDING
        image = image.reshape(*self.view.shape(scale), 3)
        return Frame(image, {"total": time.perf_counter() - start}, (said,))
