"""A scene on the service: opened when first needed, seen through the best product that there is.

A fixed-view product answers for one camera. Until it is there, and while the camera moves, a
preview of it answers, or else a view in direct light for that camera. A product that takes any
camera answers for all. Edits of materials that a method holds fixed are in its product: frames with
them are drawn once it has been precomputed for them.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Mapping
from dataclasses import asdict, replace
from pathlib import Path, PurePath
from typing import Any, NamedTuple

from engine.diagnosis import Diagnosis
from engine.errors import EditError, EditNotSupported, NotFound
from engine.measure.previews import SHOWN, doubled
from engine.methods import METHODS
from engine.methods.base import EDITS, Frame, Product
from engine.methods.fixed_view.preview import DirectPreview
from engine.scene.camera import Camera
from engine.scene.edits import Edits, apply, edited_camera
from engine.scene.open import open_scene, scenes
from engine.scene.scene import Scene
from server.intake import SENT
from server.precompute import Key, Materials, Task, key_of, settings_of
from server.shelf import Recent, Shelf, Shelved

METHOD = "direct_to_indirect"
QUICK = "preview"  # in the name of a quick version on the shelf
MAP_FILES, MEASURED_FILES = {".hdr", ".exr"}, {".brdf", ".binary", ".csv"}
MOST_FILES = 100
MOST_PIXELS = 1 << 23
PIXEL_BYTES = 300  # of what a camera sees, four points at edges included
CAMERA = frozenset({"camera"})
HELD = CAMERA | {"materials"}  # what products may be made for


Direct = Recent[tuple[str, str, Camera], DirectPreview]
"""Views by scene, what they show, and camera."""


class View(NamedTuple):
    """What draws a frame: `scale` is left for it to apply; `method` names it to the user.

    `made_for` are the keys of the edits that it was made for, and takes none of; `notices` what to
    say of it in every frame; `size` (width, height) of the picture where the renderer draws it half
    as wide. Direct light for a method that takes edits of materials is that on the scene's own,
    unless it has lamps alone.
    """

    renderer: Product | DirectPreview
    scale: int
    method: str
    made_for: frozenset[str]
    notices: tuple[Diagnosis, ...] = ()
    size: tuple[int, int] | None = None

    def relight(self, edits: Edits) -> Frame:
        """The frame under the edits."""
        rest = edits.model_copy(update=dict.fromkeys(self.made_for))
        frame = self.renderer.relight(rest, self.scale)
        image = frame.image if self.size is None else doubled(frame.image, *self.size)
        return replace(frame, image=image, warnings=(*self.notices, *frame.warnings))


class Stage:
    """One scene. `scene` may be called from any thread; `view` from the render thread alone."""

    def __init__(
        self,
        name: str,
        source: str,
        description: str,
        shelf: Shelf,
        direct: Direct,
    ) -> None:
        """shelf and direct are where its products and its views in direct light lie, beside those
        of other scenes.
        """
        self.name, self.source, self.description = name, source, description
        self._shelf, self._direct = shelf, direct
        self._lock = threading.Lock()
        self._scene: Scene | None = None
        self._settings: dict[str, Mapping[str, Any]] = {}

    def scene(self) -> Scene:
        """The opened scene; what is wrong with it is raised every time."""
        with self._lock:
            if self._scene is None:
                try:
                    self._scene = open_scene(self.source)
                except NotFound:  # which says where it looked
                    raise NotFound(f"the file of scene {self.name!r} is gone") from None
            return self._scene

    @property
    def sent(self) -> bool:
        """Whether somebody sent it."""
        return self.name.startswith(SENT)

    def camera(self, edits: Edits) -> Camera:
        """The camera under the edits. Raises EditError, for a picture that is too large too."""
        camera = edited_camera(self.scene().camera, edits.camera)
        if camera.width * camera.height > MOST_PIXELS:
            raise EditError(
                f"{camera.width} x {camera.height} pixels are more than the {MOST_PIXELS >> 20} "
                "million that the service draws; `relight render` draws larger pictures",
                field="camera",
            )
        return camera

    def with_materials(self, materials: Materials | None) -> Scene:
        """The scene under edits of materials. Raises EditError."""
        return apply(self.scene(), Edits(materials=materials))

    def maps(self) -> list[str]:
        """Names of the environment maps in the scene's folder; a built-in scene has none."""
        return self._files(MAP_FILES)

    def has_map(self, name: str) -> bool:
        """Whether a map of that name lies in the scene's folder itself."""
        return self._has_file(name, MAP_FILES)

    def measured(self) -> list[str]:
        """The same of measured materials."""
        return self._files(MEASURED_FILES)

    def has_measured(self, name: str) -> bool:
        """The same of measured materials."""
        return self._has_file(name, MEASURED_FILES)

    def _files(self, kinds: set[str]) -> list[str]:
        if self.source in scenes():
            return []
        names = sorted(path.name for path in Path(self.source).parent.glob("*"))
        return [name for name in names if self._has_file(name, kinds)][:MOST_FILES]

    def _has_file(self, name: str, kinds: set[str]) -> bool:
        if self.source in scenes() or PurePath(name).name != name or "\0" in name:
            return False
        path = Path(self.source).parent / name
        return path.suffix.lower() in kinds and path.is_file()

    def product(
        self, camera: Camera, method: str = METHOD, materials: Materials | None = None
    ) -> Product | None:
        """The product for this view and these materials, if it is loaded."""
        return self._shelf.get((self.name, _key(camera, method, materials)))

    def install(self, task: Task, product: Product) -> None:
        """Use the product of a task from now on."""
        self._shelf.keep((self.name, task.key[-1]), product, _beside(task))
        self._shelf.let_go((self.name, task.key[-1], QUICK))
        self._settings[task.method] = task.settings

    def install_preview(self, task: Task, product: Product) -> None:
        """Use a quick version until the product of the task is there."""
        if self._shelf.get((self.name, task.key[-1])) is None:
            self._shelf.keep((self.name, task.key[-1], QUICK), product, _beside(task) // 4)

    def has_preview(self, task: Task) -> bool:
        """Whether it has one."""
        return self._shelf.get((self.name, task.key[-1], QUICK)) is not None

    def settings(self, method: str) -> Mapping[str, Any]:
        """Those of the last product of the method, in place of its defaults: others follow it."""
        return self._settings.get(method, {})

    def view(
        self,
        camera: Camera,
        scale: int,
        method: str = METHOD,
        materials: Materials | None = None,
        settings: Mapping[str, Any] | None = None,
    ) -> View:
        """The best there is for this camera; `settings` are some of the method's `run_time`.

        Raises EditNotSupported for materials that the method holds fixed and has no product for,
        or for settings that are not taken any more.
        """
        name = (self.name, _key(camera, method, materials))
        if settings:
            _require_run_time(method, settings)
        whole = self._shelf.use(name)
        shelved = whole or self._shelf.use((*name, QUICK))
        if shelved is not None:
            product = _retuned(shelved, method, settings or {})
            view = View(product, scale, product.method, HELD - EDITS[method])
            if whole is not None:
                return view
            size = (camera.width, camera.height) if scale == 1 else None
            return view._replace(scale=1, notices=(SHOWN,), size=size)
        if materials and "materials" not in EDITS[method]:
            raise EditNotSupported(
                f"{method} holds materials fixed: have it precomputed with these first",
                field="materials",
            )
        lamps_alone = METHODS[method].lamps_alone
        scene = self.with_materials(materials) if lamps_alone else self.scene()
        kind = json.dumps([lamps_alone, materials if lamps_alone else None], sort_keys=True)
        preview = self._direct.use((self.name, kind, camera))
        if preview is not None:
            return View(preview, scale, "direct", HELD)
        if scale > 1:
            # A camera that moves would pay for a full buffer at every step: trace fewer rays.
            camera = camera.reduced(scale)
        preview = DirectPreview(scene.with_camera(camera), lamps_alone)
        self._direct.keep((self.name, kind, camera), preview)
        return View(preview, 1, "direct", HELD)


def _beside(task: Task) -> int:
    """Bytes of what the task's camera sees, which a product has beside its transport."""
    return PIXEL_BYTES * task.camera.width * task.camera.height


def _require_run_time(method: str, settings: Mapping[str, Any]) -> None:
    able = METHODS[method].run_time
    for name in sorted(settings.keys() - able):
        listed = ", ".join(sorted(able)) or "none"
        raise EditNotSupported(
            f"{method} takes {listed} of its settings in a frame; precompute it with others",
            field=f"settings.{name}",
        )


def _retuned(shelved: Shelved, method: str, settings: Mapping[str, Any]) -> Product:
    """The product with other settings, made at once; those used last are kept."""
    product, chosen = shelved.product, METHODS[method]
    if not settings or chosen.retuned is None:
        return product
    wanted = settings_of(method, {**asdict(product.settings), **settings})
    if wanted == product.settings:
        return product
    known = shelved.tuned.use(wanted)
    if known is None:
        known = chosen.retuned(product, wanted)
        shelved.tuned.keep(wanted, known)
    return known


def _key(camera: Camera, method: str, materials: Materials | None) -> Key:
    """See `key_of`; raises NotFound for a method that there is not."""
    if method not in METHODS:
        raise NotFound(f"there is no method {method!r}; there are {', '.join(METHODS)}")
    return key_of(method, camera, materials)
