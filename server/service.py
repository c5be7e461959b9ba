"""What the routes share: the scenes, the render thread, the jobs."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

from engine.errors import EditNotSupported, NotFound
from engine.light.maps import BUILT_IN
from engine.light.sky import Sky
from engine.light.table import LIGHTS
from engine.methods import METHODS, prepare
from engine.methods.base import Progress
from engine.scene.camera import Camera
from engine.scene.scene import Scene
from server.jobs import Jobs
from server.precompute import Task, run_in_process, settings_of
from server.stage import METHOD, Stage, Stages
from server.wire import (
    EnvironmentDetail,
    JobState,
    MethodState,
    Notice,
    PrecomputeRequest,
    SceneDetail,
)
from server.worker import Drawn, Order, Worker, draw

Precompute = Callable[[Task, Progress], None]


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
        self.jobs = Jobs(self._work)
        self._precompute = precompute

    def close(self) -> None:
        """Stop the jobs and the render thread."""
        self.jobs.close()
        self.worker.close()

    def _work(self, task: Task, progress: Progress) -> None:
        """One job: fill the store elsewhere, then load the product from it."""
        self._precompute(task, progress)
        stage = self.stages.get(task.scene)
        scene = stage.scene().with_camera(task.camera)
        settings = settings_of(task.method, task.settings)
        stage.install(task.camera, task.method, prepare(scene, task.method, settings, progress))

    def look(
        self, stage: Stage, camera: Camera, watcher: str, method: str = METHOD
    ) -> JobState | None:
        """Somebody looks through this camera: the job that makes its product, None if it is there.

        A task that failed or was cancelled by request is not started again by looking.
        """
        if stage.product(camera, method) is not None:
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

    async def frame(self, stage: Stage, order: Order, watcher: str) -> Drawn:
        """Draw one frame, for a client that waits for this very one."""
        camera = await asyncio.to_thread(stage.camera, order.edits)
        job = None
        if order.scale == 1:
            job = self.look(stage, camera, watcher, order.method)
        drawn = await self.worker.run(lambda: draw(stage, order))
        return with_job(drawn, job)

    def start(self, stage: Stage, request: PrecomputeRequest) -> JobState:
        """A precompute that somebody asked for by name."""
        if request.method not in METHODS:
            raise NotFound(f"there is no method {request.method!r}; there are {', '.join(METHODS)}")
        others = request.edits.touched() - {"camera"}
        if others:
            raise EditNotSupported(
                f"a precompute takes a camera only, not {', '.join(sorted(others))}",
                field=f"edits.{min(others)}",
            )
        settings_of(request.method, request.settings)
        camera = stage.camera(request.edits)
        return self.jobs.start(self.task(stage, camera, request.method, request.settings), "api")

    def task(
        self,
        stage: Stage,
        camera: Camera,
        method: str = METHOD,
        settings: Mapping[str, Any] | None = None,
    ) -> Task:
        """What to precompute for a view."""
        return Task(
            scene=stage.name,
            source=stage.source,
            camera=camera,
            method=method,
            settings={**(self.settings if method == METHOD else {}), **(settings or {})},
        )

    def detail(self, stage: Stage) -> SceneDetail:
        """Everything the page needs to know about a scene; opens it."""
        scene = stage.scene()
        methods = []
        for method in METHODS.values():
            product = stage.product(scene.camera, method.name)
            methods.append(
                MethodState(
                    name=method.name,
                    paper=method.paper,
                    edits=sorted(method.edits),
                    ready=product is not None,
                    bytes=product.bytes if product is not None else 0,
                )
            )
        return SceneDetail(
            name=stage.name,
            description=stage.description,
            camera=scene.camera,
            diagonal=scene.diagonal,
            lights=[light.model_dump() for light in scene.lights],
            light_types=light_types(),
            environment=environment_detail(scene),
            materials=list(scene.material_names),
            objects=list(scene.object_names),
            triangles=len(scene.geometry.triangles),
            methods=methods,
            warnings=[Notice(**asdict(diagnosis)) for diagnosis in scene.diagnoses],
            job=self.jobs.active(self.task(stage, scene.camera)),
        )


def light_types() -> dict[str, dict[str, Any]]:
    """The JSON schema of every kind of light, by its `type`."""
    return {kind.model_fields["type"].default: kind.model_json_schema() for kind in LIGHTS}


def environment_detail(scene: Scene) -> EnvironmentDetail:
    """What the page needs to know to edit a scene's environment."""
    own = scene.environment
    return EnvironmentDetail(
        description=None if own is None else own.description.model_dump(),
        maps=list(BUILT_IN),
        sky=Sky.model_json_schema(),
    )


def with_job(drawn: Drawn, job: JobState | None) -> Drawn:
    """The frame, with the job that its view waits for in the header."""
    if job is None:
        return drawn
    return Drawn(drawn.header.model_copy(update={"job": job.id}), drawn.image)
