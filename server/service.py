"""What the routes share: the scenes, the render thread, the jobs."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

from engine.errors import EditError, EditNotSupported, InputError, NotFound
from engine.measure.front import judged_by, known_front
from engine.methods import EDITS, METHODS
from engine.scene.camera import Camera
from engine.scene.edits import Edits
from engine.store import Store
from server import maps, measured
from server.compared import KEPT as KEPT_COMPARED
from server.compared import MOST_PIXELS, Compared
from server.details import material_details, scene_detail
from server.intake import Intake
from server.jobs import API, Jobs
from server.maps import Uploads
from server.measured import Samples
from server.metrics import Metrics
from server.precompute import Materials, Task, run_in_process, settings_of
from server.products import Precompute, Products
from server.reader import Reader
from server.scenes import SentScenes
from server.shelf import Recent
from server.stage import HELD, METHOD, Stage
from server.stages import Stages
from server.wire import Chart, JobState, MaterialDetail, PrecomputeRequest, SceneDetail
from server.worker import Drawn, Order, Worker, draw, relit


class Service:
    """Scenes, frames and precomputes.

    `precompute` fills the store with a task's product; `settings` replace some of the
    defaults of METHOD in every task.
    """

    def __init__(
        self,
        stages: Stages,
        precompute: Precompute = run_in_process,
        settings: Mapping[str, Any] | None = None,
    ) -> None:
        self.stages = stages
        self.settings = dict(settings or {})
        self.worker = Worker()
        self.metrics = Metrics()
        self.sessions = 0  # live sockets that are open
        self.products = Products(stages, precompute, lambda task: self.jobs.previewed(task))
        self.jobs = Jobs(self.products)
        self.reader = Reader()
        root, intake = Store().root, Intake()
        self.uploads = Uploads(root / "maps", intake)
        self.samples = Samples(root / "measured", intake)
        self.sent = SentScenes(root / "scenes", stages, intake, left=self.jobs.cancel_all)
        self.compared: Recent[str, Compared] = Recent(KEPT_COMPARED)

    def close(self) -> None:
        """Stop the jobs and the threads."""
        self.jobs.close()
        self.products.close()
        self.reader.close()
        self.worker.close()

    def look(self, stage: Stage, edits: Edits, watcher: str, method: str) -> JobState | None:
        """Somebody looks through a camera: the job that makes its product, None if it is there.

        A task that failed or was cancelled by request is not started again by looking, nor is one
        for other materials, which have to be asked for by name.
        """
        camera = stage.camera(edits)
        held = edits.materials and "materials" not in EDITS[method]
        if held or stage.product(camera, method) is not None:
            self.jobs.look_away(watcher)
            return None
        task = self.task(stage, camera, method)
        active = self.jobs.active(task)
        if active is None:
            refused = self.jobs.refused(task)
            if refused is not None:
                self.jobs.look_away(watcher)
                return refused
        return self.jobs.start(task, watcher)

    def located(self, edits: Edits, stage: Stage) -> Edits:
        """Edits from outside, with the files that they name where they are. Raises EditError."""
        return measured.located(maps.located(edits, stage, self.uploads), stage, self.samples)

    async def acquire(self, stage: Stage, edits: Edits) -> None:
        """Have what is measured of edits from outside read, so that no frame waits for it."""
        if edits.materials:
            found = measured.located(edits, stage, self.samples)
            await self.reader.read(stage, found.materials)

    async def frame(self, stage: Stage, order: Order, watcher: str) -> Drawn:
        """Draw one frame, for a client that waits for this very one."""
        await asyncio.to_thread(stage.scene)
        await self.reader.read(stage, order.edits.materials)
        job = None
        if order.scale == 1:
            job = self.look(stage, order.edits, watcher, order.method)
        drawn = await self.worker.run(lambda: draw(stage, order))
        return with_job(drawn, job)

    def start(self, stage: Stage, request: PrecomputeRequest) -> JobState:
        """A precompute that somebody asked for by name."""
        known(request.method)
        others = request.edits.touched() - HELD
        if others:
            raise EditNotSupported(
                f"a precompute takes a camera and materials only, not {', '.join(sorted(others))}",
                field=f"edits.{min(others)}",
            )
        settings_of(request.method, request.settings or {})
        materials = measured.located(request.edits, stage, self.samples).materials or {}
        stage.with_materials(materials)
        camera = stage.camera(request.edits)
        task = self.task(stage, camera, request.method, request.settings, materials)
        return self.jobs.start(task, API)

    def task(
        self,
        stage: Stage,
        camera: Camera,
        method: str = METHOD,
        settings: Mapping[str, Any] | None = None,
        materials: Materials | None = None,
    ) -> Task:
        """What to precompute for a view; a product that any camera may use is one for all.

        Without settings it is made as the last one of the method was.
        """
        chosen = stage.settings(method) if settings is None else settings
        if "camera" in EDITS.get(method, ()):
            camera = stage.scene().camera
        return Task(
            scene=stage.name,
            source=stage.source,
            camera=camera,
            materials=materials or {},
            method=method,
            settings=self.usual(method) | dict(chosen),
        )

    def usual(self, method: str) -> dict[str, Any]:
        """Settings of a method in place of its defaults, where nobody asks for others."""
        return dict(self.settings) if method == METHOD else {}

    def chart(self, stage: Stage, method: str) -> Chart:
        """What settings of a method cost on a scene, where it was measured."""
        usual, scene = settings_of(known(method), self.usual(method)), stage.scene()
        found = known_front(scene, method, usual, Store())
        if found is None:
            try:
                kinds = list(judged_by(scene, method))
            except InputError:
                kinds = []
            job = self.jobs.active(self._measuring(stage, method))
            return Chart(scene=stage.name, method=method, kinds=kinds, points=[], job=job)
        product = stage.product(scene.camera, method)
        if product is not None:
            used = product.settings
        else:
            used = settings_of(method, self.task(stage, scene.camera, method).settings)
        same = [k for k, p in enumerate(found.points) if p.settings == asdict(used)]
        return Chart(
            scene=stage.name,
            method=method,
            kinds=list(found.kinds),
            points=list(found.points),
            current=same[0] if same else None,
        )

    def measure(self, stage: Stage, method: str) -> JobState:
        """A job that fills in the chart. InputError where the scene has nothing to edit by it."""
        judged_by(stage.scene(), known(method))
        return self.jobs.start(self._measuring(stage, method), API)

    def _measuring(self, stage: Stage, method: str) -> Task:
        return Task(
            scene=stage.name,
            source=stage.source,
            camera=stage.scene().camera,
            method=method,
            settings=self.usual(method),
            work="front",
        )

    async def compare(self, stage: Stage, order: Order, error: float, seconds: float) -> JobState:
        """Draw the order, and start a job that has the reference of the same edits."""
        await asyncio.to_thread(stage.scene)
        camera = stage.camera(order.edits)
        if camera.width * camera.height > MOST_PIXELS:
            raise EditError(f"a reference has at most {MOST_PIXELS} pixels", field="camera")
        await self.reader.read(stage, order.edits.materials)
        frame, method = await self.worker.run(lambda: relit(stage, order))
        scene = stage.scene()
        task = Task(
            scene=stage.name,
            source=stage.source,
            camera=camera,
            method=order.method,
            settings=order.settings,
            work="reference",
            edits=order.edits,
            error=error,
            seconds=seconds,
        )
        job = self.jobs.start(task, API)
        self.compared.keep(job.id, Compared(scene, task, frame.image, method))
        return job

    def detail(self, stage: Stage) -> SceneDetail:
        """Everything the page needs to know about a scene; opens it."""
        job = self.jobs.active(self.task(stage, stage.scene().camera))
        choices = measured.choices(stage, self.samples)
        return scene_detail(stage, self.uploads.all(), choices, job)

    def materials(self, stage: Stage, edits: Edits, method: str) -> list[MaterialDetail]:
        """The materials under edits from outside, with files as edits call them."""
        edits = measured.located(edits, stage, self.samples)
        return material_details(stage, edits, method, self.samples.name_of)


def known(method: str) -> str:
    """The method's name; NotFound where there is none of that name."""
    if method not in METHODS:
        raise NotFound(f"there is no method {method!r}; there are {', '.join(METHODS)}")
    return method


def with_job(drawn: Drawn, job: JobState | None) -> Drawn:
    """The frame, with the job that its view waits for in the header."""
    if job is None:
        return drawn
    return Drawn(drawn.header.model_copy(update={"job": job.id}), drawn.image)
