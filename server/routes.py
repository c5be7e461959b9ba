"""The HTTP routes and the live socket."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncIterator
from typing import Annotated, Any

from fastapi import APIRouter, Body, Header, Query, Request, Response, WebSocket
from fastapi.responses import PlainTextResponse, StreamingResponse
from pydantic import TypeAdapter

from engine.errors import NotFound
from engine.images import encode
from engine.scene.edits import Edits
from server.accept import MEDIA_TYPES, negotiate
from server.details import map_thumbnail, picked, scene_summary
from server.live import Session
from server.maps import located
from server.metrics import MEDIA_TYPE
from server.problems import describe, in_json
from server.rates import client_of
from server.service import Service
from server.stage import METHOD
from server.wire import (
    Exposure,
    JobState,
    LiveProblem,
    MaterialDetail,
    Picked,
    Place,
    PrecomputeRequest,
    Problem,
    Quality,
    Scale,
    SceneDetail,
    SceneSummary,
)
from server.worker import Order

HEARTBEAT_SECONDS = 15.0
SETTINGS = TypeAdapter(dict[str, Any])

PROBLEM: dict[str, Any] = {"model": Problem, "content": {"application/problem+json": {}}}
PROBLEMS: dict[int | str, dict[str, Any]] = dict.fromkeys((404, 422, 429, 503), PROBLEM)
router = APIRouter(responses=PROBLEMS)


def service_of(request: Request | WebSocket) -> Service:
    """The service that the app was made with."""
    service: Service = request.app.state.service
    return service


@router.get("/healthz")
async def healthz() -> dict[str, str]:
    """Answers as long as the service lives."""
    return {"status": "ok"}


@router.get("/metrics", response_class=PlainTextResponse)
async def metrics(request: Request) -> Response:
    """How long frames take and how many there were, as Prometheus reads it."""
    service = service_of(request)
    now = {
        "sessions": float(service.sessions),
        "frames_waiting": float(service.worker.waiting),
        "jobs": float(service.jobs.at_work),
        "product_bytes": float(service.stages.shelf.bytes),
    }
    return Response(
        service.metrics.text(now), media_type=MEDIA_TYPE, headers={"Cache-Control": "no-store"}
    )


@router.get("/api/scenes")
async def list_scenes(request: Request) -> list[SceneSummary]:
    """All scenes; the default one first."""
    stages = service_of(request).stages
    return [scene_summary(stage, stages) for stage in [*stages.stages.values()]]


@router.get("/api/scenes/{scene}")
async def scene_detail(request: Request, scene: str) -> SceneDetail:
    """Description, methods, editable things, readiness; opens the scene."""
    service = service_of(request)
    return await asyncio.to_thread(service.detail, service.stages.get(scene))


@router.post(
    "/api/scenes/{scene}/frame",
    response_class=Response,
    responses={
        200: {
            "content": {media: {} for media in MEDIA_TYPES},
            "headers": {
                "Server-Timing": {"schema": {"type": "string"}},
                "Relight-Frame": {"description": "the frame's header as JSON"},
            },
        },
        406: {"model": Problem, "content": {"application/problem+json": {}}},
    },
)
async def frame(
    request: Request,
    scene: str,
    edits: Annotated[Edits, Body()] = Edits(),  # noqa: B008 - frozen
    exposure: Annotated[Exposure, Query()] = 0.0,
    scale: Annotated[Scale, Query()] = 1,
    quality: Annotated[Quality, Query()] = 90,
    method: Annotated[str, Query()] = METHOD,
    settings: Annotated[str, Query(description="in JSON, see MethodState")] = "{}",
    accept: Annotated[str, Header()] = "*/*",
) -> Response:
    """The scene under the edits, as an image; OpenEXR is linear and ignores the exposure."""
    service, came = service_of(request), time.perf_counter()
    stage = service.stages.get(scene)
    media_type, image_format = negotiate(accept)
    order = Order(
        edits=service.located(edits, stage),
        exposure=exposure,
        scale=scale,
        format=image_format,
        quality=quality,
        method=method,
        settings=in_json(SETTINGS, settings, "settings"),
    )
    drawn = await service.frame(stage, order, watcher=f"http {scene} {client_of(request.scope)}")
    service.metrics.frame(drawn.header, "http", time.perf_counter() - came)
    timing = ", ".join(f"{name};dur={ms}" for name, ms in drawn.header.timings.items())
    return Response(
        drawn.image,
        media_type=media_type,
        headers={
            "Server-Timing": timing,
            "Relight-Frame": ascii_json(drawn.header.model_dump_json()),
            "Cache-Control": "no-store",
            "Vary": "Accept",
        },
    )


@router.post(
    "/api/scenes/{scene}/environment",
    response_class=Response,
    responses={200: {"content": {"image/png": {}}}},
)
async def environment_thumbnail(
    request: Request,
    scene: str,
    edits: Annotated[Edits, Body()] = Edits(),  # noqa: B008 - frozen
) -> Response:
    """A small picture of the environment's map, not turned, as bright as shows it well."""
    service = service_of(request)
    stage = service.stages.get(scene)
    edits = located(edits, stage, service.uploads)
    image = await asyncio.to_thread(map_thumbnail, stage, edits)
    return Response(encode(image, "png"), media_type="image/png")


@router.post("/api/scenes/{scene}/materials")
async def materials(
    request: Request,
    scene: str,
    edits: Annotated[Edits, Body()] = Edits(),  # noqa: B008 - frozen
    method: Annotated[str, Query()] = METHOD,
) -> list[MaterialDetail]:
    """The materials under the edits; how the method models them, once its product is there."""
    service = service_of(request)
    stage = service.stages.get(scene)
    await asyncio.to_thread(stage.scene)
    await service.acquire(stage, edits)
    return await asyncio.to_thread(service.materials, stage, edits, method)


@router.post("/api/scenes/{scene}/pick")
async def pick(
    request: Request,
    scene: str,
    x: Annotated[Place, Query()],
    y: Annotated[Place, Query()],
    edits: Annotated[Edits, Body()] = Edits(),  # noqa: B008 - frozen
) -> Picked:
    """What the camera of the edits shows at a place of its picture."""
    stage = service_of(request).stages.get(scene)
    return await asyncio.to_thread(picked, stage, edits, x, y)


def ascii_json(text: str) -> str:
    """JSON that fits a header: whatever is not ASCII is escaped."""
    return "".join(c if c.isascii() else f"\\u{ord(c):04x}" for c in text if ord(c) < 0x10000)


@router.post("/api/scenes/{scene}/precompute", status_code=202)
async def precompute(
    request: Request,
    response: Response,
    scene: str,
    wanted: Annotated[PrecomputeRequest, Body()] = PrecomputeRequest(),  # noqa: B008 - frozen
) -> JobState:
    """Start a precompute, or join the one that is at it."""
    service = service_of(request)
    job = await asyncio.to_thread(service.start, service.stages.get(scene), wanted)
    response.headers["Location"] = f"/api/jobs/{job.id}"
    return job


@router.get("/api/jobs/{job}")
async def job_state(request: Request, job: str) -> JobState:
    """Where the job stands."""
    return service_of(request).jobs.get(job)


@router.delete("/api/jobs/{job}")
async def cancel_job(request: Request, job: str) -> JobState:
    """Stop the job; what it has stored stays, so that a new one goes on from there."""
    return service_of(request).jobs.cancel(job)


@router.get(
    "/api/jobs/{job}/events",
    response_class=StreamingResponse,
    responses={200: {"content": {"text/event-stream": {}}}},
)
async def job_events(request: Request, job: str) -> StreamingResponse:
    """The job's state as server-sent events, at every change, until it ends."""
    service = service_of(request)
    service.jobs.get(job)
    return StreamingResponse(_events(service, job), media_type="text/event-stream")


async def _events(service: Service, identity: str) -> AsyncIterator[str]:
    loop = asyncio.get_running_loop()
    states: asyncio.Queue[JobState] = asyncio.Queue()

    def heard(state: JobState) -> None:
        if state.id == identity:
            loop.call_soon_threadsafe(states.put_nowait, state)

    stop = service.jobs.listen(heard)
    try:
        state = service.jobs.get(identity)
        while True:
            yield f"event: job\ndata: {state.model_dump_json()}\n\n"
            if state.status not in ("queued", "running"):
                return
            try:
                state = await asyncio.wait_for(states.get(), HEARTBEAT_SECONDS)
            except TimeoutError:
                yield ": still here\n\n"
    finally:
        stop()


@router.websocket("/api/scenes/{scene}/live")
async def live(socket: WebSocket, scene: str) -> None:
    """Edits in, frames out; see `server.live`."""
    await socket.accept()
    service = service_of(socket)
    try:
        stage = service.stages.get(scene)
    except NotFound as error:
        await socket.send_text(LiveProblem(problem=describe(error)).model_dump_json())
        await socket.close(code=4404)
        return
    await Session(service, stage, socket).run()
