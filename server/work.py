"""What the process of `server.precompute` does; whatever it makes it leaves in the store."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from engine.measure.front import front
from engine.measure.previews import halved, preview_settings
from engine.measure.truth import truth
from engine.methods import prepare
from engine.methods.base import Progress
from engine.scene.edits import Edits, apply
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.store import Store
from server.precompute import PREVIEW, PREVIEW_READY, Task, preview_store, settings_of
from server.wire import Work


def do(task: Task, progress: Progress) -> None:
    """Open the task's scene, then do its work."""
    progress("open scene", 0, 1)
    _WORK[task.work](task, open_scene(task.source), progress)


def _product(task: Task, scene: Scene, progress: Progress) -> None:
    scene = apply(scene, Edits(materials=task.materials)).with_camera(task.camera)
    settings = settings_of(task.method, task.settings)
    quick = preview_settings(scene, task.method, settings) if task.preview else None
    if quick is not None:
        _preview(task, scene, quick, progress)
    product = prepare(scene, task.method, settings, progress)
    # What frames need is compiled here and kept, so that the render thread need not wait.
    for scale in (2, 1):
        product.relight(Edits(), scale, "cpu")


def _preview(task: Task, scene: Scene, settings: Any, progress: Progress) -> None:
    """A product that is kept apart, so that nobody takes it for the one that was asked for."""

    def told(phase: str, done: float, total: float) -> None:
        progress(PREVIEW + phase, done, total)

    prepare(halved(scene), task.method, settings, told, store=preview_store(task))
    progress(PREVIEW_READY, 1, 1)


def _front(task: Task, scene: Scene, progress: Progress) -> None:
    front(scene, task.method, settings_of(task.method, task.settings), Store(), progress)


def _reference(task: Task, scene: Scene, progress: Progress) -> None:
    truth(scene, task.edits, task.error, Store(), progress, max_seconds=task.seconds)


_WORK: dict[Work, Callable[[Task, Scene, Progress], None]] = {
    "product": _product,
    "front": _front,
    "reference": _reference,
}
