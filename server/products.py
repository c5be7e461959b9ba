"""From a task to the product in the hands of its stage: made elsewhere, loaded in a thread.

Where the whole product takes long, the process that makes it leaves a preview first. That is loaded
from a store of its own, which is removed then, and drawn with until the whole one is there.
"""

from __future__ import annotations

import logging
import threading
from collections.abc import Callable, Set
from concurrent.futures import ThreadPoolExecutor, wait

from engine.errors import Cancelled, RelightError
from engine.measure.previews import halved, preview_settings
from engine.methods import prepare
from engine.methods.base import Product, Progress
from engine.scene.scene import Scene
from server.precompute import PREVIEW_READY, Task, preview_store, settings_of
from server.stage import Stage
from server.stages import Stages

log = logging.getLogger(__name__)

Precompute = Callable[[Task, Progress], None]

POLL_SECONDS = 0.1
READING = {"view samples", "vertices"}  # phases of a product that is in the store


class _NotThere(Exception):
    """The store has not got all of a product."""


class Products:
    """Does tasks; called by the thread of the jobs."""

    def __init__(
        self, stages: Stages, precompute: Precompute, previewed: Callable[[Task], None]
    ) -> None:
        """precompute fills the store; previewed(task) hears that frames have a preview."""
        self._stages, self._precompute, self._previewed = stages, precompute, previewed
        self._loader = ThreadPoolExecutor(1, "relight-load")

    def close(self) -> None:
        """Finish what is at hand, drop the rest."""
        self._loader.shutdown(wait=True, cancel_futures=True)

    def __call__(self, task: Task, progress: Progress) -> None:
        """Fill the store if it lacks the product, then load it, if the task makes one.

        Raises within a moment what `progress` raises.
        """
        if task.work != "product":
            self._precompute(task, progress)
            return
        stage = self._stages.get(task.scene)
        try:
            stage.install(task, self._load(stage, task, progress, READING))
            return
        except _NotThere:
            ready = False

        def told(phase: str, done: float, total: float) -> None:
            nonlocal ready
            progress(phase, done, total)
            if phase == PREVIEW_READY and not ready:
                ready = True
                self._loader.submit(self._load_preview, stage, task)

        wanted = task.model_copy(update={"preview": not stage.has_preview(task)})
        self._precompute(wanted, told)
        stage.install(task, self._load(stage, task, progress))

    def _load(
        self, stage: Stage, task: Task, progress: Progress, phases: Set[str] | None = None
    ) -> Product:
        """Loading seldom asks whether to go on, so somebody else asks meanwhile.

        Raises _NotThere where it would take other phases than these.
        """
        given_up = threading.Event()

        def still(phase: str, done: float, total: float) -> None:
            if given_up.is_set():
                raise Cancelled("nobody waits for this product any more")
            if phases is not None and phase not in phases:
                raise _NotThere

        settings = settings_of(task.method, task.settings)
        future = self._loader.submit(prepare, _seen(stage, task), task.method, settings, still)
        try:
            while not wait([future], POLL_SECONDS).done:
                progress("load", 0, 1)
        except BaseException:
            given_up.set()
            raise
        return future.result()

    def _load_preview(self, stage: Stage, task: Task) -> None:
        """Without it frames are as they were: the whole product is on its way."""
        store = preview_store(task)
        try:
            scene = _seen(stage, task)
            whole = settings_of(task.method, task.settings)
            quick = preview_settings(scene, task.method, whole)
            product = prepare(halved(scene), task.method, quick, store=store)
        except (RelightError, MemoryError) as error:
            log.warning("no preview of %s: %s", task.scene, error)
            return
        stage.install_preview(task, product)
        store.remove()
        self._previewed(task)


def _seen(stage: Stage, task: Task) -> Scene:
    return stage.with_materials(task.materials).with_camera(task.camera)
