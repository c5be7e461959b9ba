"""A sitting with a built-in scene: pictures of its edits, and references beside them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from engine.measure.contact_sheet import Row, difference, picture
from engine.measure.document import finite, provenance
from engine.measure.edges import pixels_that_count
from engine.measure.machine import this_machine
from engine.measure.metrics import auto_exposure, flip_ldr, relative_l2
from engine.measure.settings import settings_from
from engine.measure.truth import Truth, truth
from engine.methods import METHODS, prepare
from engine.methods.base import Progress, silent
from engine.scene.edits import Edits, edited_camera
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.store import Store

METHOD = "brdf_editing"
WIDTH = 256  # of pictures, unless told otherwise
FULL = 0.3  # part of the reference's mean at which the colours of a difference are full
REFERENCE_ERROR = 0.03

Image = NDArray[np.float32]
Materials = Mapping[str, Mapping[str, Any]]


@dataclass(frozen=True)
class Session:
    """What all figures are made with.

    width            of pictures, pixels; the height follows from the scene's camera
    fixed            settings that hold where a figure does not set them
    reference_error  relative L2 error that references are rendered to
    store            where they and the products are kept
    """

    width: int = WIDTH
    fixed: Mapping[str, Any] = field(default_factory=dict)
    reference_error: float = REFERENCE_ERROR
    store: Store = field(default_factory=Store)
    progress: Progress = silent

    def scene(self, name: str) -> Scene:
        """A built-in scene in the size of the figures."""
        scene = open_scene(name)
        camera = scene.camera
        size = {"width": self.width, "height": round(self.width * camera.height / camera.width)}
        return scene.with_camera(edited_camera(camera, size))

    def images(self, scene: Scene, edits: Sequence[Materials], **settings: Any) -> list[Image]:
        """The method's pictures of the edited scene, one edit after the other in one sitting."""
        chosen = settings_from(METHODS[METHOD].settings, {**self.fixed, **settings})
        product = prepare(scene, METHOD, chosen, self.progress, store=self.store)
        return [product.relight(edits_of(each)).image for each in edits]

    def truth(self, scene: Scene, edit: Materials, bounces: int | None = None) -> Truth:
        """The reference of light that bounces so often behind the first, or to its end."""
        limit = None if bounces is None else bounces + 1
        return truth(
            scene,
            edits_of(edit),
            self.reference_error,
            self.store,
            self.progress,
            max_bounces=limit,
        )

    def document(self, figure: int, scene: Scene, pictures: list[dict[str, Any]]) -> dict[str, Any]:
        """The numbers of a figure."""
        settings = settings_from(METHODS[METHOD].settings, self.fixed)
        return finite(
            {
                **provenance(),
                "machine": this_machine().as_dict(),
                "method": METHOD,
                "figure": figure,
                "scene": scene.name,
                "width": scene.camera.width,
                "height": scene.camera.height,
                "settings": asdict(settings),
                "reference_error": self.reference_error,
                "seed": settings.seed,
                "pictures": pictures,
            }
        )


def edits_of(materials: Materials) -> Edits:
    """The edits that hold them."""
    return Edits(materials={name: dict(change) for name, change in materials.items()})


class Compared:
    """Pictures of one edit beside their reference: two rows of a sheet, and their numbers."""

    def __init__(self, session: Session, scene: Scene, reference: Truth, name: str) -> None:
        self._reference, self._name = reference, name
        self._kept = pixels_that_count(scene)
        self._exposure = auto_exposure(reference.image)
        self._shown: list[Any] = []
        self._off: list[Any] = []
        self.numbers: list[dict[str, Any]] = []

    def add(self, image: Image, title: str) -> None:
        """A picture of the method, and where it is off."""
        truth, kept = self._reference, self._kept
        off = relative_l2(image, truth.image, kept, truth.variance)
        flip = flip_ldr(image, truth.image, kept, self._exposure)
        self._shown.append(picture(image, self._exposure, f"{self._name}: {title}"))
        caption = f"{off:.1%} off, FLIP {flip:.3f}"
        self._off.append(difference(image, truth.image, kept, FULL, caption))
        self.numbers.append({"edit": self._name, "title": title, "relative_l2": off, "flip": flip})

    def rows(self) -> list[Row]:
        """The pictures and the reference, and below them what is off."""
        reference = picture(self._reference.image, self._exposure, "path tracer")
        return [Row(self._name, [*self._shown, reference]), Row("off by", [*self._off, None])]
