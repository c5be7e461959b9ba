"""What the process of `server.precompute` does; whatever it makes it leaves in the store."""

from __future__ import annotations

from collections.abc import Callable

from engine.measure.front import front
from engine.measure.truth import truth
from engine.methods import prepare
from engine.methods.base import Progress
from engine.scene.edits import Edits, apply
from engine.scene.open import open_scene
from engine.scene.scene import Scene
from engine.store import Store
from server.precompute import Task, settings_of
from server.wire import Work


def do(task: Task, progress: Progress) -> None:
    """Open the task's scene, then do its work."""
    progress("open scene", 0, 1)
    _WORK[task.work](task, open_scene(task.source), progress)


def _product(task: Task, scene: Scene, progress: Progress) -> None:
    scene = apply(scene, Edits(materials=task.materials)).with_camera(task.camera)
    product = prepare(scene, task.method, settings_of(task.method, task.settings), progress)
    # What frames need is compiled here and kept, so that the render thread need not wait.
    for scale in (2, 1):
        product.relight(Edits(), scale, "cpu")


def _front(task: Task, scene: Scene, progress: Progress) -> None:
    front(scene, task.method, settings_of(task.method, task.settings), Store(), progress)


def _reference(task: Task, scene: Scene, progress: Progress) -> None:
    truth(scene, task.edits, task.error, Store(), progress, max_seconds=task.seconds)


_WORK: dict[Work, Callable[[Task, Scene, Progress], None]] = {
    "product": _product,
    "front": _front,
    "reference": _reference,
}
